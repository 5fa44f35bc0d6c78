// A convex body on a level plane: where it comes to rest, and the section that it rolls on.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "geometry/vec.hpp"

namespace cairn::fragility {

struct RestingPose {
  std::array<std::size_t, 3> facet{};                // points that bear, counter-clockwise from outside
  geometry::Mat3 turn = geometry::Mat3::Identity();  // given frame -> frame with the facet's normal straight down
  double tilt = 0.0;                                 // rad: between the given vertical and the facet's normal
  int rolls = 0;                                     // facets it rolled over before it rested
};

// The facet of the convex hull on which the body rests: that below the centre of mass along the given z, then rolled
// over the edges that the centre of mass stands outside of, until its foot lies inside (each roll lowers the centre).
// points: of the body, m; centre: inside their hull. Empty for fewer than four points that span a volume, or a
// centre outside. Gift wrapping: cost linear in points a facet visited.
[[nodiscard]] std::optional<RestingPose> resting_pose(std::span<const geometry::Vec3> points,
                                                      const geometry::Vec3& centre);

// The lower side of the hull's section by the vertical plane through `centre` along the unit vector `along`
// (horizontal): corners (distance along, height) relative to the centre, ascending along, slopes within +-90 degrees.
// points: in the pose (z up, the facet level). Walks over the hull's facets from the one at rest, both ways.
[[nodiscard]] std::vector<geometry::Vec2> lower_section(std::span<const geometry::Vec3> points,
                                                        const std::array<std::size_t, 3>& facet,
                                                        const geometry::Vec3& centre, const geometry::Vec2& along);

}  // namespace cairn::fragility
