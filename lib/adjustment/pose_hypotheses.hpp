// The ways in which a pose is commonly misread, each as a correction that can be tried.
#pragma once

#include <string>
#include <vector>

#include "geometry/rigid_transform.hpp"

namespace cairn::adjustment {

// What must be done to the poses as given so that they become T_world_camera in cairn's convention.
// The parts are applied in the order of the members, as a reader would: order of the quaternion's
// components, direction of the transform, camera axes, world axes, turn of the raster.
struct PoseHypothesis {
  enum class Order { wxyz, was_xyzw, was_shifted_back };
  enum class Direction { as_given, inverted, rotation_inverted, position_is_translation };
  enum class CameraAxes { right_down_forward, right_up_back, forward_right_down };
  enum class WorldAxes { east_north_up, north_east_down };

  Order order = Order::wxyz;
  Direction direction = Direction::as_given;
  CameraAxes camera_axes = CameraAxes::right_down_forward;
  WorldAxes world_axes = WorldAxes::east_north_up;
  int turned_deg = 0;  // 0, 90, 180, 270: by how much the raster was turned clockwise after the exposure

  // Number of parts that differ from the declared convention: the simplest explanation wins.
  [[nodiscard]] int parts() const;
  // Codes of the parts joined by '+', e.g. "quaternion_order_xyzw+pose_inverted"; "as_declared".
  [[nodiscard]] std::string code() const;
  // One sentence for people, and what to do about it.
  [[nodiscard]] std::string meaning() const;
  [[nodiscard]] std::string remedy() const;

  // The corrected pose. A turn of the raster is applied as a roll about the optical axis: exact for a
  // principal point at the image centre and distortion without tangential terms.
  [[nodiscard]] geometry::RigidTransform apply(const geometry::RigidTransform& given) const;

  friend bool operator==(const PoseHypothesis&, const PoseHypothesis&) = default;
};

// Every hypothesis worth trying, "as declared" first, then by number of parts (75 in all).
[[nodiscard]] const std::vector<PoseHypothesis>& pose_hypotheses();

}  // namespace cairn::adjustment
