// Closed criteria of overturning for simple motions of the ground. All ratios are without unit.
#pragma once

namespace cairn::fragility {

// Least velocity step V_min = (2 g / p) sin(alpha/2) / cos(alpha), m/s: exact, undamped, one side.
// alpha 0..pi/2 [rad], p > 0 [rad/s]. With `slender`, g alpha / p.
[[nodiscard]] double velocity_step(double alpha, double p, bool slender = false);

// Rectangular pulse of duration t1 [s], slender: least a / (g alpha) = 1 / (1 - exp(-p t1)).
// The same as Housner's (1963) cosh(p t1) = 1 + 1/(2 x (x - 1)).
[[nodiscard]] double rectangular_pulse_ratio(double p, double t1);

// Half sine, one half cycle a sin(omega t), slender, without impact; q = omega / p > 0.
// Least a / (g alpha) = 1 / sin(psi), psi the root in (0, pi/2] of
//   q sin(psi) - cos(psi) = exp(-(pi - psi) / q).
// Solved to 1e-15 in psi.
[[nodiscard]] double half_sine_ratio(double q);
// Housner's a / (g alpha) = sqrt(1 + q^2): drops the right side above and overestimates the strength of the rock
// by 1.07 to 1.68 (q = 1 .. 8). For comparison only.
[[nodiscard]] double half_sine_ratio_housner(double q);

// Free rocking from r = theta_0 / alpha, 0 < r < 1: p T/4 = acosh(1 / (1 - r)), small alpha.
[[nodiscard]] double quarter_period_times_p(double r);

// Angular velocity kept at an impact of a rectangle: 1 - 1.5 sin^2(alpha) (Housner 1963).
[[nodiscard]] double rectangle_restitution(double alpha);

}  // namespace cairn::fragility
