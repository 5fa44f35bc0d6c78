// Smooth trajectories through points: least integral of the squared fourth derivative.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "survey/mission.hpp"

namespace cairn::planning {

// East, north, up [m]; yaw [rad, counter-clockwise from east, not wrapped].
using Pose4 = Eigen::Vector4d;

// Where the first key lies on a flight already under way (paper A code, D32). Higher derivatives are zero.
struct StartState {
  Pose4 velocity = Pose4::Zero();  // m/s, rad/s
};

// One polynomial of degree 9 between each two keys (paper A, A25 and misprint E6: ten coefficients), in position and
// yaw, continuous up to the fourth derivative, at rest (derivatives 1 to 4 zero) at the last key, and at the first but
// for its velocity. The derivatives at the inner keys are those of least integral of |fourth derivative|^2: Richter,
// Bry, Roy 2016 (their unconstrained form). The system is block-tridiagonal with blocks of 4, the same for all four
// coordinates, and solved by block elimination.
// keys: 2 or more; durations [s]: one less, each > 0. Throws invalid_argument otherwise, or where a number is not
// finite. Cost linear in keys, about 2 us each.
[[nodiscard]] std::vector<survey::PolynomialSegment> minimum_snap(std::span<const Pose4> keys,
                                                                  std::span<const double> durations,
                                                                  const StartState& start = {});

// Derivative of order 0..9 at time t [s] since the segment's start.
[[nodiscard]] Pose4 evaluate(const survey::PolynomialSegment& segment, double t, int derivative = 0);

// At time t since the start of the whole trajectory; before it the first point, after it the last.
[[nodiscard]] Pose4 evaluate(std::span<const survey::PolynomialSegment> trajectory, double t, int derivative = 0);

[[nodiscard]] double duration(std::span<const survey::PolynomialSegment> trajectory);

}  // namespace cairn::planning
