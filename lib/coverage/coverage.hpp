// Predicted visibility of a surface, facet by facet.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "coverage/sight_information.hpp"
#include "coverage/view.hpp"
#include "geometry/triangle_mesh.hpp"
#include "visibility/scene.hpp"

namespace cairn::coverage {

struct CoverageOptions {
  double frame_margin = 0.0;  // a facet's centroid must keep this fraction of width and height from the border
  double end_gap = 1e-4;      // fraction of the segment camera -> centroid, at its end, where nothing is tested
  bool metrics = true;        // false: counts only
  NoiseOptions noise;         // for the predicted sigma

  void visit(base::OptionVisitor& v) {
    v.real("frame-margin", frame_margin, 0.0, 0.45,
           "border of the image that does not count, as a fraction of its width and height");
    v.real("end-gap", end_gap, 0.0, 0.1,
           "last part of each sight line that is not tested for obstacles, as a fraction");
    v.real("pixel-sigma-px", noise.pixel_sigma_px, 1e-3, 100.0, "standard deviation of an image measurement, px");
    v.real("position-sigma-m", noise.position_sigma_m, 0.0, 1000.0,
           "standard deviation of a camera's position where the frame does not state it, m");
    v.real("rotation-sigma-deg", noise.rotation_sigma_deg, 0.0, 90.0,
           "standard deviation of a camera's attitude where the frame does not state it, deg");
    v.flag("metrics", metrics, "ground sampling distance, incidence and parallax beside the counts");
  }
};

// Occupied bins of FacetCoverage::azimuths, 0..12.
[[nodiscard]] inline int azimuth_bins(std::uint16_t azimuths) {
  return std::popcount(azimuths);
}

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
  std::vector<float> incidence_median_deg;  // of the views (lower median)
  std::vector<float> parallax_deg;          // largest angle between two sight lines
  std::vector<float> parallax_second_deg;   // of all pairs the second largest; NaN below 3 views
  std::vector<float> sigma_max_mm;          // predicted standard deviation along the direction known worst
  std::vector<float> sigma_z_mm;            // the same, up
  std::vector<std::uint16_t> azimuths;      // bit k: a view from azimuth 30 k to 30 (k + 1) deg, clockwise from north
  std::size_t skipped = 0;                  // degenerate or non-finite facets; all their values are 0 or NaN
  std::uint64_t rays = 0;                   // segments traced
};

// scene: of the same mesh, or of a larger one that holds it (what else may stand in the way).
//
// Ground sampling distance: square root of the area on the facet's plane that one pixel covers at the
// centroid, z^3 / (r fx fy m cos i) for depth z, range r, incidence i and the distortion's magnification m
// (from a table, relative error below 1e-3). Angles: exact to single precision (1e-4 deg). Parallax: the exact
// largest two of all pairs; pairs that cannot be among them are left out (a ball about the best pair found so far).
// Azimuth: of the camera seen from the facet; a view from straight above has none. Sigma: point_sigma() over the views,
// with the distortion's magnification taken as equal in all directions.
//
// Facets are sorted into tiles of 128; a view is asked only about tiles its frustum meets, and rays to
// neighbours travel together. Cost: tiles x views + rays x log(facets); memory: 70 bytes a facet.
// Results do not depend on threads. Throws invalid_argument for options out of range, invalid_input for a view
// without camera or with a pose that is not finite.
[[nodiscard]] FacetCoverage coverage(const geometry::TriangleMesh& mesh, const visibility::Scene& scene,
                                     const ViewSet& views, const CoverageOptions& options, base::RunContext& ctx);

}  // namespace cairn::coverage
