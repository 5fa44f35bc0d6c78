// Views for tests.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>

#include "coverage/view.hpp"

namespace cairn::testing {

inline survey::Camera pinhole_camera(double focal_px, std::int64_t width, std::int64_t height) {
  survey::Camera camera;
  camera.id = survey::CameraId(0);
  camera.width_px = width;
  camera.height_px = height;
  camera.fx_px = camera.fy_px = focal_px;
  camera.cx_px = 0.5 * static_cast<double>(width);
  camera.cy_px = 0.5 * static_cast<double>(height);
  return camera;
}

// Pose that looks from `at` to `target`; the image's x axis is horizontal.
inline geometry::RigidTransform looking_at(const geometry::Vec3& at, const geometry::Vec3& target) {
  const geometry::Vec3 forward = (target - at).normalized();
  const geometry::Vec3 side = std::abs(forward.z()) > 0.999 ? geometry::Vec3::UnitY() : geometry::Vec3::UnitZ();
  const geometry::Vec3 right = forward.cross(side).normalized();
  geometry::RigidTransform T;
  T.rotation.col(0) = right;
  T.rotation.col(1) = forward.cross(right);
  T.rotation.col(2) = forward;
  T.translation = at;
  return T;
}

inline void add_view(coverage::ViewSet& set, const geometry::Vec3& at, const geometry::Vec3& target) {
  set.views.push_back({survey::FrameId(static_cast<std::int64_t>(set.views.size())), 0, looking_at(at, target)});
}

}  // namespace cairn::testing
