// What a record of ground acceleration is measured by, and simple pulses.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace cairn::fragility {

// Peaks of a record. Velocity and displacement start from zero and are integrated by trapezoids (the acceleration
// runs straight between samples, so the velocity is exact at the samples); no baseline is taken off.
struct GroundMotionMeasures {
  double pga_m_s2 = 0.0;
  double pgv_m_s = 0.0;
  double pgd_m = 0.0;
  double final_velocity_m_s = 0.0;  // a baseline error shows here
  double duration_s = 0.0;          // (count - 1) dt
};
// acceleration [m/s^2] at constant step dt [s]; at least two samples. Throws invalid_argument otherwise.
[[nodiscard]] GroundMotionMeasures measures(std::span<const double> acceleration, double dt);

struct SpectralOrdinate {
  double displacement = 0.0;           // SD: greatest |u|, m
  double pseudo_acceleration = 0.0;    // PSA = w^2 SD, m/s^2
  double absolute_acceleration = 0.0;  // SA: greatest |u'' + a_g|, m/s^2
};
// Linear oscillator from rest; exact for acceleration that runs straight between samples (Nigam & Jennings 1969).
// period [s] > 0, damping a share of critical, 0 <= damping < 1. Peaks are taken at the samples, and after the end
// over one free cycle. Where dt > period / 20 the record is cut finer (straight lines), so that peaks between the
// samples count. Cost linear in samples.
[[nodiscard]] SpectralOrdinate spectral_ordinate(std::span<const double> acceleration, double dt, double period,
                                                 double damping = 0.05);

// Median over directions 0, 1, .. 179 deg of a peak of two horizontal components turned (RotD50, Boore 2010);
// period 0 gives PGA, otherwise PSA [m/s^2]. Components of unequal length are cut to the shorter.
[[nodiscard]] double rotd50(std::span<const double> first, std::span<const double> second, double dt, double period,
                            double damping = 0.05);

// One cosine of acceleration, the pulse of the overturning diagrams (Purvance; virtual shake robot): displacement
// A - A cos(2 pi F t) for one period, so that PGA = 4 pi^2 F^2 A and PGV/PGA = 1/(2 pi F).
// pga [m/s^2] > 0, pgv_over_pga [s] > 0. samples: per period, at least 50.
struct Pulse {
  double dt = 0.0;
  std::vector<double> acceleration;  // m/s^2
};
[[nodiscard]] Pulse one_cosine(double pga, double pgv_over_pga, std::size_t samples = 400);
// Half a sine of acceleration: a sin(omega t), 0 <= t <= pi / omega.
[[nodiscard]] Pulse half_sine(double amplitude, double omega, std::size_t samples = 400);
// Constant acceleration for `duration`.
[[nodiscard]] Pulse rectangular_pulse(double amplitude, double duration);

}  // namespace cairn::fragility
