// Place and heading on a map.
#pragma once

#include <cmath>

#include "geometry/vec.hpp"

namespace cairn::geometry {

struct Pose2 {
  Vec2 position = Vec2::Zero();  // local ENU east and north, m
  double yaw = 0.0;              // of the forward axis, counter-clockwise from east, rad

  // Forward (x) and left (y) of the pose -> local east, north.
  [[nodiscard]] Vec2 to_world(const Vec2& p) const {
    const double c = std::cos(yaw), s = std::sin(yaw);
    return position + Vec2(c * p.x() - s * p.y(), s * p.x() + c * p.y());
  }
};

}  // namespace cairn::geometry
