// Pictures, depth and instance masks of a scene, by ray casting.
#pragma once

#include <cstdint>
#include <vector>

#include "base/options.hpp"
#include "geometry/rigid_transform.hpp"
#include "simulation/render_scene.hpp"
#include "survey/camera.hpp"

namespace cairn::simulation {

struct RenderOptions {
  std::int64_t samples = 2;  // rays along each side of a pixel for the picture, 1..8
  bool image = true;         // false: depth and mask only
  double far_m = 1000.0;     // nothing is seen beyond, m
  // Noise of the sensor, standard deviation in 8-bit grey levels, 0..50; drawn from (seed, frame, row).
  double image_noise = 1.2;

  void visit(base::OptionVisitor& visitor);
};

// Rows from the top, row-major. Depth and mask are those of the ray through each pixel's centre.
struct RenderedFrame {
  std::int64_t width_px = 0, height_px = 0;
  std::vector<std::uint8_t> rgb;        // 3 a pixel; empty without `image`
  std::vector<float> depth_m;           // along the camera's z axis; 0 = nothing hit
  std::vector<std::uint16_t> instance;  // object + 1 where the pixel shows an object; 0 for terrain, pedestal and sky
};

// The camera with its distortion, at T_world_camera. Pixels that the distortion model cannot invert are black, of
// depth 0. The same bytes for any number of threads. About 0.1 Mpixel a CPU second with samples = 2 and shadows
// (docs/benchmarks.md).
[[nodiscard]] RenderedFrame render(const RenderScene& scene, const survey::Camera& camera,
                                   const geometry::RigidTransform& T_world_camera, const RenderOptions& options,
                                   std::uint64_t seed = 0, std::uint64_t frame = 0);

// Noise of a stereo or structured-light depth camera.
struct DepthNoise {
  // Standard deviation a z^2 [1/m]: disparity noise over focal length and base, 0.0018 for a R200-like sensor.
  double quadratic = 0.0018;
  double nearest_m = 0.5, farthest_m = 20.0;  // range outside which nothing returns, m
  double edge_hole = 0.5;    // chance that a pixel beside a jump of more than 5 % returns nothing, 0..1
  double patch_hole = 0.02;  // share of pixels lost in patches of about 12 pixels (weak texture), 0..0.5

  void visit(base::OptionVisitor& visitor);
};

// In place; drawn from (seed, frame, row). The patches of lost pixels move from frame to frame.
void add_depth_noise(RenderedFrame& frame, const DepthNoise& noise, std::uint64_t seed, std::uint64_t frame_number);

// Millimetres as depth files hold them: 0 where there is no return, or beyond 65.535 m.
[[nodiscard]] std::vector<std::uint16_t> depth_millimetres(const RenderedFrame& frame);

}  // namespace cairn::simulation
