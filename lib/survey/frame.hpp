// One image with its pose.
#pragma once

#include <cstdint>
#include <string>

#include "geometry/rigid_transform.hpp"
#include "survey/ids.hpp"

namespace cairn::survey {

struct Frame {
  FrameId id;
  std::int64_t time_ns = 0;  // on the survey's time base; 0 with TimeBase::unknown = not known
  CameraId camera;
  std::string image;                        // path relative to the survey folder, or absolute; "" = no image kept
  geometry::RigidTransform T_world_camera;  // world = local ENU; camera x right, y down, z forward
  double sigma_xy_m = 0.0;                  // 1 sigma of the position; 0 = not known
  double sigma_z_m = 0.0;
  double sigma_rot_deg = 0.0;
};

}  // namespace cairn::survey
