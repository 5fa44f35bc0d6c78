// Gimbal angles to a camera's rotation: the one yaw-pitch-roll chain of cairn.
#pragma once

#include "base/angle.hpp"
#include "geometry/vec.hpp"
#include "survey/camera.hpp"

namespace cairn::camera {

// Angles against north-east-down, order ZYX: yaw clockwise from north, pitch up from the horizon
// (-90 deg looks straight down), roll clockwise about the viewing direction.
struct GimbalAngles {
  base::Angle yaw, pitch, roll;
};

// How the camera sits on the body that the angles are of (body: x forward, y right, z down).
enum class CameraMount {
  forward,  // looks along the body's x, image right = body y: a gimbal
  nadir,    // looks along the body's z, image top = body x: a camera fixed below a vehicle
};

// R_ned_camera = Rz(yaw) Ry(pitch) Rx(roll) R_body_camera; camera x right, y down, z forward.
// DJI's gimbal angles are these with CameraMount::forward.
[[nodiscard]] geometry::Mat3 ned_from_camera(const GimbalAngles& angles, CameraMount mount = CameraMount::forward);

// The same in east-north-up. The local frame's axes are those of the survey's origin: at a distance of
// 1 km from it they turn by up to 0.01 deg against the local meridian (at 45 deg latitude), which is
// not corrected.
[[nodiscard]] geometry::Mat3 enu_from_camera(const GimbalAngles& angles, CameraMount mount = CameraMount::forward);

// The rotation of a camera whose pixels were turned by 180 degrees after the photograph was taken:
// a half turn about the optical axis.
[[nodiscard]] geometry::Mat3 turned_half(const geometry::Mat3& rotation_from_camera);

// That camera: principal point and tangential terms mirrored.
[[nodiscard]] survey::Camera turned_half(const survey::Camera& camera);

}  // namespace cairn::camera
