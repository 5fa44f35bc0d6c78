// Intrinsics of a camera as plain data; the mathematics is in module `camera`.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "survey/ids.hpp"

namespace cairn::survey {

// x_d = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + tangential(p1, p2), OpenCV's order and signs.
//   pinhole: no distortion; radial: k1, k2 (COLMAP SIMPLE_RADIAL, RADIAL); brown: k1, k2, k3, p1, p2;
//   fisheye: equidistant, theta_d = theta (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4 t^8).
enum class CameraModel { pinhole, radial, brown, fisheye };

[[nodiscard]] std::string_view name_of(CameraModel model);
[[nodiscard]] std::optional<CameraModel> camera_model_from(std::string_view name);

// Pixels in the corner convention: the first pixel's centre is (0.5, 0.5).
struct Camera {
  CameraId id;
  std::string name;
  CameraModel model = CameraModel::pinhole;
  std::int64_t width_px = 0, height_px = 0;  // of the image files, > 0
  double fx_px = 0.0, fy_px = 0.0;           // > 0
  double cx_px = 0.0, cy_px = 0.0;
  double k1 = 0.0, k2 = 0.0, k3 = 0.0, k4 = 0.0, p1 = 0.0, p2 = 0.0;

  friend bool operator==(const Camera&, const Camera&) = default;
};

}  // namespace cairn::survey
