// Plain questions of visibility: which frames saw a point, what is seen from one.
#pragma once

#include <cstdint>
#include <limits>
#include <string_view>
#include <vector>

#include "coverage/coverage.hpp"

namespace cairn::coverage {

enum class Sight : std::uint8_t { seen, out_of_frame, occluded };
[[nodiscard]] std::string_view name_of(Sight sight);

// One view's sight of a point.
struct PointSight {
  survey::FrameId frame;
  Sight sight = Sight::out_of_frame;
  double range_m = 0.0;
  // NaN where out of frame: pixel (corner convention), sampling distance square to the sight line.
  geometry::Vec2 pixel = geometry::Vec2::Constant(std::numeric_limits<double>::quiet_NaN());
  double gsd_mm = std::numeric_limits<double>::quiet_NaN();
  double blocked_at_m = std::numeric_limits<double>::quiet_NaN();  // range of what stands in the way
};

// One row a view, in their order. The point need not lie on the surface; end_gap of the segment is not tested. The
// sampling distance leaves distortion out. Throws as coverage(), and invalid_argument for a point that is not finite.
[[nodiscard]] std::vector<PointSight> who_sees(const geometry::Vec3& point, const visibility::Scene& scene,
                                               const ViewSet& views, const CoverageOptions& options);

// One flag a facet: its centroid is seen from `eye`, from the facet's front. All 0 where eye is not finite.
// Cost: rays x log(facets).
[[nodiscard]] std::vector<std::uint8_t> viewshed(const geometry::TriangleMesh& mesh, const visibility::Scene& scene,
                                                 const geometry::Vec3& eye, double end_gap = 1e-4);

}  // namespace cairn::coverage
