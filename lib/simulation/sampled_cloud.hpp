// Point clouds with label truth, as photogrammetry or a scanner would make them of a scene.
#pragma once

#include <cstdint>
#include <span>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "geometry/point_cloud.hpp"
#include "geometry/rigid_transform.hpp"
#include "simulation/render_scene.hpp"
#include "survey/camera.hpp"

namespace cairn::simulation {

struct CloudOptions {
  double spacing_m = 0.01;  // edge of the cubes of which each keeps at most one point, 0.001..10
  double noise_m = 0.005;   // standard deviation along the normal, independent from point to point, >= 0
  // Error of the surface as a whole, correlated over waviness_length_m: what a smooth fit does not take away.
  double waviness_m = 0.0;
  double waviness_length_m = 0.25;
  double outlier_share = 0.0;    // points thrown up to half a metre off the surface, 0..0.5
  double contact_width_m = 0.0;  // points of rock and pedestal this near to the rim are basal contact; 0 = 1.5 spacings
  double margin_m = 0.0;         // only points this near (in plan) to the box round a rock or pedestal; 0 = all
  std::int64_t min_views = 2;    // views that must see a point, where views are given
  double max_incidence_deg = 80.0;  // of a sight line that counts, from the normal
  double max_range_m = 200.0;       // of a sight line

  void visit(base::OptionVisitor& visitor);
};

struct View {
  survey::Camera camera;
  geometry::RigidTransform T_world_camera;
};

// Columns of the cloud: colour as the sun lights it; `label` (u8: 0 none, 1 terrain, 2 rock, 3 pedestal, 4 basal
// contact) and `target_id` (u32: the object; 4294967295 none), as `cairn segment` writes them. Points stand in the
// order of their cubes. With views: what at least min_views of them see. Without: every outer surface from which
// a way leads to the sky, or half a metre and more to the outer side of another surface (undersides of overhangs).
// The same bytes for any number of threads; random numbers are keyed by (ctx.seed, triangle or point). About
// 1.5 million points a CPU minute of exposed surface. Throws resource_exhausted past ctx's memory limit or 400
// million samples, invalid_argument for options out of range.
[[nodiscard]] geometry::PointCloud sample_cloud(const RenderScene& scene, std::span<const View> views,
                                                const CloudOptions& options, base::RunContext& ctx);

}  // namespace cairn::simulation
