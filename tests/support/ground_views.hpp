// A camera that looks at a place on the ground, and the boxes of solids in its image.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "camera/projection.hpp"
#include "survey/camera.hpp"
#include "survey/frame.hpp"

namespace cairn::testing {

// 1280 x 720 px, 67 deg across: the field of a small board camera.
inline survey::Camera board_camera() {
  survey::Camera camera;
  camera.id = survey::CameraId(1);
  camera.width_px = 1280;
  camera.height_px = 720;
  camera.fx_px = camera.fy_px = 960.0;
  camera.cx_px = 640.0;
  camera.cy_px = 360.0;
  return camera;
}

// Camera at `from`, its axis through `at`, image x level. Not straight down along the vertical: then x points east.
inline survey::Frame frame_looking(const geometry::Vec3& from, const geometry::Vec3& at) {
  survey::Frame frame;
  frame.id = survey::FrameId(1);
  frame.camera = survey::CameraId(1);
  const geometry::Vec3 z = (at - from).normalized();
  geometry::Vec3 x = z.cross(geometry::Vec3::UnitZ());
  x = x.norm() < 1e-9 ? geometry::Vec3(geometry::Vec3::UnitX()) : geometry::Vec3(x.normalized());
  frame.T_world_camera.rotation.col(0) = x;
  frame.T_world_camera.rotation.col(1) = z.cross(x);
  frame.T_world_camera.rotation.col(2) = z;
  frame.T_world_camera.translation = from;
  return frame;
}

// Box of an upright frustum from dense points: radius `bottom` at the foot, `top` at its height.
inline geometry::PixelBox frustum_box(const survey::Camera& camera, const geometry::RigidTransform& pose,
                                      const geometry::Vec3& foot, double bottom, double top, double height) {
  geometry::PixelBox box{1e9, 1e9, -1e9, -1e9};
  constexpr int kAround = 3600;
  for (int i = 0; i < kAround; ++i)
    for (const bool upper : {false, true}) {
      const double a = 2.0 * std::numbers::pi * i / kAround, r = upper ? top : bottom;
      const auto p = camera::project_world(
          camera, pose, foot + geometry::Vec3(r * std::cos(a), r * std::sin(a), upper ? height : 0.0));
      box = {std::min(box.xmin, p->x()), std::min(box.ymin, p->y()), std::max(box.xmax, p->x()),
             std::max(box.ymax, p->y())};
    }
  return box;
}

}  // namespace cairn::testing
