// Where a planned camera looks.
#pragma once

#include "geometry/rigid_transform.hpp"
#include "geometry/vec.hpp"
#include "survey/camera.hpp"

namespace cairn::planning {

// T_world_camera of a camera at `position` that looks along heading (clockwise from north) and pitch (0 = horizon, -90
// = straight down), level. Looking straight down the image's upper edge points along the heading.
[[nodiscard]] geometry::RigidTransform camera_pose(const geometry::Vec3& position, double heading_deg,
                                                   double pitch_deg);

struct Aim {
  double heading_deg = 0.0;
  double pitch_deg = 0.0;
};
// From one point to another. Straight below or above, the heading is `otherwise_deg` (gimbal lock, D26).
[[nodiscard]] Aim aim_at(const geometry::Vec3& from, const geometry::Vec3& to, double otherwise_deg = 0.0);

// `heading` plus whole turns, closest to `reference` [deg].
[[nodiscard]] double unwrapped(double heading_deg, double reference_deg);

// Yaw [rad, counter-clockwise from east] of a heading; keeps whole turns.
[[nodiscard]] double yaw_of_heading(double heading_deg);

// Angles of the rays through the middle of the four image edges against the optical axis, rad.
struct FieldOfView {
  double up = 0.0, down = 0.0, left = 0.0, right = 0.0;
};
// Throws invalid_argument for a camera whose edges cannot be unprojected.
[[nodiscard]] FieldOfView field_of_view(const survey::Camera& camera);

}  // namespace cairn::planning
