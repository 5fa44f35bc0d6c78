// How the ground moves under a rock, as plain vectors.
#pragma once

#include <span>
#include <vector>

#include "geometry/vec.hpp"

namespace cairn::dynamics {

// Velocity of the ground [m/s, local ENU] at times 0, step, 2 step, ..; linear between samples (the acceleration is
// constant over a step). The ground rests before the first sample and keeps the last velocity after the last one.
struct BaseMotion {
  double step_s = 0.01;  // > 0
  std::vector<geometry::Vec3> velocity_m_s;

  // Time of the last sample [s]; 0 without samples.
  [[nodiscard]] double duration() const;
  // Velocity at time t [s]; zero for t < 0 and without samples.
  [[nodiscard]] geometry::Vec3 velocity(double t) const;
};

// One cosine of displacement (fragility.md 3.1): a = pga cos(w t), v = pga/w sin(w t), w = 1 / pgv_over_pga, one period
// 2 pi pgv_over_pga. The ground first accelerates towards toward_deg [deg clockwise from +y], so that a rock tends to
// topple the other way first. pga_m_s2 >= 0, pgv_over_pga_s > 0; `samples` >= 16 pieces a period.
[[nodiscard]] BaseMotion one_cosine(double pga_m_s2, double pgv_over_pga_s, double toward_deg, int samples = 2000);

// From accelerations [m/s^2] at equal steps, by the trapezoidal rule, starting at rest.
[[nodiscard]] BaseMotion from_acceleration(double step_s, std::span<const geometry::Vec3> acceleration_m_s2);

// The same history with every velocity multiplied by `factor`.
[[nodiscard]] BaseMotion scaled(BaseMotion motion, double factor);

// Throws invalid_argument for a step that is not positive or a velocity that is not finite.
void require_valid(const BaseMotion& motion);

}  // namespace cairn::dynamics
