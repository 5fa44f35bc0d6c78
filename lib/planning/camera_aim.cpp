#include "planning/camera_aim.hpp"

#include <cmath>
#include <numbers>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "camera/dji_pose.hpp"
#include "camera/projection.hpp"

namespace cairn::planning {

geometry::RigidTransform camera_pose(const geometry::Vec3& position, double heading_deg, double pitch_deg) {
  const camera::GimbalAngles angles{base::Angle::from_deg(heading_deg), base::Angle::from_deg(pitch_deg), {}};
  return {camera::enu_from_camera(angles), position};
}

Aim aim_at(const geometry::Vec3& from, const geometry::Vec3& to, double otherwise_deg) {
  constexpr double kStraight = 1e-6;  // m beside the vertical
  const geometry::Vec3 d = to - from;
  const double flat = std::hypot(d.x(), d.y());
  return {flat > kStraight ? base::azimuth_deg(d.x(), d.y()) : otherwise_deg,
          base::rad_to_deg(std::atan2(d.z(), flat))};
}

double unwrapped(double heading_deg, double reference_deg) {
  return heading_deg + 360.0 * std::round((reference_deg - heading_deg) / 360.0);
}

double yaw_of_heading(double heading_deg) {
  return base::deg_to_rad(90.0 - heading_deg);
}

FieldOfView field_of_view(const survey::Camera& camera) {
  const auto w = static_cast<double>(camera.width_px), h = static_cast<double>(camera.height_px);
  const auto angle = [&camera](double u, double v) {
    const auto ray = camera::unproject(camera, {u, v});
    if (!ray || !(ray->z() > 0.0))
      throw base::Error(base::ErrorCode::invalid_argument, "the camera's field of view reaches a right angle or more")
          .record("camera " + std::to_string(camera.id.value))
          .hint("Give a pinhole camera of less than 150 degrees");
    return std::atan2(std::hypot(ray->x(), ray->y()), ray->z());
  };
  return {angle(camera.cx_px, 0.0), angle(camera.cx_px, h), angle(0.0, camera.cy_px), angle(w, camera.cy_px)};
}

}  // namespace cairn::planning
