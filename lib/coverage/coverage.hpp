// Predicted visibility of a surface, facet by facet.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "coverage/view.hpp"
#include "geometry/triangle_mesh.hpp"
#include "visibility/scene.hpp"

namespace cairn::coverage {

struct CoverageOptions {
  double frame_margin = 0.0;  // a facet's centroid must keep this fraction of width and height from the border
  double end_gap = 1e-4;      // fraction of the segment camera -> centroid, at its end, where nothing is tested
  bool metrics = true;        // false: counts only

  void visit(base::OptionVisitor& v) {
    v.real("frame-margin", frame_margin, 0.0, 0.45,
           "border of the image that does not count, as a fraction of its width and height");
    v.real("end-gap", end_gap, 0.0, 0.1,
           "last part of each sight line that is not tested for obstacles, as a fraction");
    v.flag("metrics", metrics, "ground sampling distance, incidence and parallax beside the counts");
  }
};

// One value a facet of the mesh given. A view counts for a facet when the facet's centroid lies inside the
// frame, the facet faces the camera, and the segment from camera to centroid meets nothing.
struct FacetCoverage {
  std::vector<std::uint32_t> views;     // seen from
  std::vector<std::uint32_t> in_frame;  // centroid inside the frame
  std::vector<std::uint32_t> facing;    // and facing the camera
  // NaN where `views` is 0 (parallax and second incidence: below 2); empty where metrics were not asked for.
  std::vector<float> gsd_best_mm;           // least ground sampling distance, mm/px
  std::vector<float> gsd_median_mm;         // of the views (lower median)
  std::vector<float> incidence_best_deg;    // least angle between sight line and normal
  std::vector<float> incidence_second_deg;  // second least
  std::vector<float> parallax_deg;          // largest angle between two sight lines
  std::size_t skipped = 0;                  // degenerate or non-finite facets; all their values are 0 or NaN
  std::uint64_t rays = 0;                   // segments traced
};

// scene: of the same mesh, or of a larger one that holds it (what else may stand in the way).
//
// Ground sampling distance: square root of the area on the facet's plane that one pixel covers at the
// centroid, z^3 / (r fx fy m cos i) for depth z, range r, incidence i and the distortion's magnification m
// (from a table, relative error below 1e-3). Angles: exact to single precision (1e-4 deg). Parallax: the exact
// largest of all pairs; pairs that cannot be the largest are left out (a ball about the best pair found so far).
//
// Facets are sorted into tiles of 128; a view is asked only about tiles its frustum meets, and rays to
// neighbours travel together. Cost: tiles x views + rays x log(facets); memory: 50 bytes a facet.
// Results do not depend on threads. Throws invalid_argument for options out of range, invalid_input for a view
// without camera or with a pose that is not finite.
[[nodiscard]] FacetCoverage coverage(const geometry::TriangleMesh& mesh, const visibility::Scene& scene,
                                     const ViewSet& views, const CoverageOptions& options, base::RunContext& ctx);

}  // namespace cairn::coverage
