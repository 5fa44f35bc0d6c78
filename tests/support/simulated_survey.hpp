// A survey of a bumpy plane with known truth: cameras at 40 m, tie points seen with a little noise.
#pragma once

#include <cmath>
#include <cstdint>

#include "base/angle.hpp"
#include "base/random.hpp"
#include "camera/projection.hpp"
#include "survey/survey.hpp"

namespace cairn::testing {

inline double bumpy_ground(double east, double north) {
  return 3.0 + 0.8 * std::sin(east / 7.0) + 0.5 * std::cos(north / 5.0);
}

// Looks down; the image's top points to `yaw_deg` clockwise from north; tilts make the rotation general.
inline geometry::Mat3 nadir_rotation(double yaw_deg, double tilt_x_deg, double tilt_y_deg) {
  geometry::Mat3 down;  // camera x = east, y = south, z = down
  down << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  return geometry::axis_rotation(geometry::Vec3::UnitZ(), -base::deg_to_rad(yaw_deg)) *
         geometry::axis_rotation(geometry::Vec3::UnitX(), base::deg_to_rad(tilt_x_deg)) *
         geometry::axis_rotation(geometry::Vec3::UnitY(), base::deg_to_rad(tilt_y_deg)) * down;
}

struct SimulatedOptions {
  std::int64_t columns = 4, rows = 3;
  double height_m = 40.0, spacing_m = 12.0;
  double noise_px = 0.3;
  std::size_t ties = 600;
  double yaw_deg = 42.0;  // of the first row; rows alternate by 180 degrees
  double tilt_deg = 2.0;  // standard deviation of both tilts
};

// Truth: every pose, tie point and observation is right.
inline survey::Survey simulated_survey(const SimulatedOptions& options = {}) {
  survey::Survey result;
  survey::Camera camera;
  camera.id = survey::CameraId(1);
  camera.model = survey::CameraModel::radial;
  camera.width_px = 1600;
  camera.height_px = 900;
  camera.fx_px = camera.fy_px = 914.0;
  camera.cx_px = 800.0;
  camera.cy_px = 450.0;
  camera.k1 = 0.004;
  camera.k2 = 0.01;
  result.manifest.cameras.push_back(camera);
  base::Random random(7, "simulated survey", 0);
  for (std::int64_t r = 0; r < options.rows; ++r)
    for (std::int64_t c = 0; c < options.columns; ++c) {
      survey::Frame frame;
      frame.id = survey::FrameId(r * options.columns + c + 1);
      frame.camera = camera.id;
      frame.time_ns = frame.id.value * 1'000'000'000;
      frame.image = "F" + std::to_string(frame.id.value) + ".JPG";
      frame.T_world_camera.rotation =
          nadir_rotation(options.yaw_deg + (r % 2 == 0 ? 0.0 : 180.0) + random.normal(),
                         options.tilt_deg * random.normal(), options.tilt_deg * random.normal());
      frame.T_world_camera.translation = {options.spacing_m * static_cast<double>(c) + 5.0,
                                          options.spacing_m * static_cast<double>(r) + 3.0, options.height_m};
      result.frames.push_back(frame);
    }
  for (std::size_t i = 0; i < options.ties; ++i) {
    survey::TiePoint tie;
    tie.id = survey::TiePointId(static_cast<std::int64_t>(i) + 1);
    const double east = random.uniform(-20.0, 60.0), north = random.uniform(-20.0, 50.0);
    tie.p_world = {east, north, bumpy_ground(east, north)};
    for (const auto& frame : result.frames) {
      const auto pixel = camera::project_world(camera, frame.T_world_camera, tie.p_world);
      if (!pixel || !camera::inside_image(camera, *pixel)) continue;
      tie.observations.push_back(
          {frame.id, *pixel + options.noise_px * geometry::Vec2(random.normal(), random.normal())});
    }
    if (tie.observations.size() >= 2) result.ties.push_back(std::move(tie));
  }
  return result;
}

}  // namespace cairn::testing
