// The views a surface is audited against.
#pragma once

#include <cstddef>
#include <vector>

#include "geometry/rigid_transform.hpp"
#include "survey/camera.hpp"
#include "survey/frame.hpp"

namespace cairn::coverage {

// One image taken, or planned.
struct View {
  survey::FrameId frame;
  std::size_t camera = 0;  // index in ViewSet::cameras
  geometry::RigidTransform T_world_camera;
  // Standard deviations of that pose, as survey::Frame; 0 = not stated.
  double sigma_xy_m = 0.0, sigma_z_m = 0.0, sigma_rot_deg = 0.0;
};

struct ViewSet {
  std::vector<survey::Camera> cameras;
  std::vector<View> views;
};

}  // namespace cairn::coverage
