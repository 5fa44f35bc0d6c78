#include "camera/dji_pose.hpp"

#include "geometry/rigid_transform.hpp"

namespace cairn::camera {
namespace {

using geometry::Mat3;
using geometry::Vec3;

Mat3 body_from_camera(CameraMount mount) {
  Mat3 m;
  // Columns: the camera's x, y, z axes in the body's.
  if (mount == CameraMount::forward) m << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  else m << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  return m;
}

}  // namespace

Mat3 ned_from_camera(const GimbalAngles& angles, CameraMount mount) {
  return geometry::axis_rotation(Vec3::UnitZ(), angles.yaw.rad()) *
         geometry::axis_rotation(Vec3::UnitY(), angles.pitch.rad()) *
         geometry::axis_rotation(Vec3::UnitX(), angles.roll.rad()) * body_from_camera(mount);
}

Mat3 enu_from_camera(const GimbalAngles& angles, CameraMount mount) {
  Mat3 enu_from_ned;
  enu_from_ned << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  return enu_from_ned * ned_from_camera(angles, mount);
}

Mat3 turned_half(const Mat3& rotation_from_camera) {
  return rotation_from_camera * Vec3(-1.0, -1.0, 1.0).asDiagonal();
}

survey::Camera turned_half(const survey::Camera& camera) {
  survey::Camera turned = camera;
  turned.cx_px = static_cast<double>(camera.width_px) - camera.cx_px;
  turned.cy_px = static_cast<double>(camera.height_px) - camera.cy_px;
  // With both axes reversed the radial part is unchanged and the quadratic tangential part changes sign.
  turned.p1 = -camera.p1;
  turned.p2 = -camera.p2;
  return turned;
}

}  // namespace cairn::camera
