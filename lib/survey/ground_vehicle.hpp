// What a ground vehicle (UGV) knows or is believed to know of its own motion.
#pragma once

#include <cstdint>
#include <optional>

#include "geometry/vec.hpp"

namespace cairn::survey {

// One moment: a line of an inertial log, of a filtered track or of a simulated vehicle's truth.
struct VehicleState {
  std::int64_t time_ns = 0;                          // on the survey's time base
  geometry::Vec2 position = geometry::Vec2::Zero();  // local ENU east and north, m
  geometry::Vec2 velocity = geometry::Vec2::Zero();  // m/s
  double roll = 0.0, pitch = 0.0;                    // rad
  double yaw = 0.0;                                  // of the forward axis, counter-clockwise from east, rad, -pi..pi
  std::optional<geometry::Mat2> covariance;          // of the position, m^2; unset = the log does not say
};

}  // namespace cairn::survey
