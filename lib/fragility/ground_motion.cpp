#include "fragility/ground_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/error.hpp"

namespace cairn::fragility {
namespace {

using base::Error;
using base::ErrorCode;

void require_series(std::span<const double> acceleration, double dt) {
  if (acceleration.size() < 2 || !(dt > 0.0) || !std::isfinite(dt))
    throw Error(ErrorCode::invalid_argument, "a record needs two samples and a positive step");
}

// One step of the damped oscillator u'' + 2 z w u' + w^2 u = -a, a straight over the step:
// u_1 = a11 u + a12 v + b11 a_0 + b12 a_1, likewise v.
struct Recurrence {
  double a11, a12, a21, a22, b11, b12, b21, b22;
};

// From the exact solution u = exp(-z w t) (C cos + S sin) + particular, particular = -(a_0 + s t)/w^2 + 2 z s/w^3.
Recurrence recurrence(double w, double z, double dt) {
  const double wd = w * std::sqrt(1.0 - z * z);
  const double e = std::exp(-z * w * dt), c = std::cos(wd * dt), s = std::sin(wd * dt);
  const double g = z * w / wd;
  Recurrence r{};
  r.a11 = e * (c + g * s);
  r.a12 = e * s / wd;
  r.a21 = -e * w * w / wd * s;
  r.a22 = e * (c - g * s);
  // Response from rest to a_0 and a_1: the free solution cancels the particular one at the start.
  const auto forced = [&](double a0, double slope, double& u, double& v) {
    const double u0 = -(-a0 / (w * w) + 2.0 * z * slope / (w * w * w));
    const double v0 = slope / (w * w);
    u = r.a11 * u0 + r.a12 * v0 - (a0 + slope * dt) / (w * w) + 2.0 * z * slope / (w * w * w);
    v = r.a21 * u0 + r.a22 * v0 - slope / (w * w);
  };
  forced(1.0, -1.0 / dt, r.b11, r.b21);
  forced(0.0, 1.0 / dt, r.b12, r.b22);
  return r;
}

// Calls visit(u, v, a) at every fine sample, then over one free cycle.
template <typename Visit>
void run_oscillator(std::span<const double> acceleration, double dt, double period, double damping, Visit visit) {
  const auto pieces = static_cast<std::size_t>(std::max(1.0, std::ceil(20.0 * dt / period)));
  const double step = dt / static_cast<double>(pieces);
  const auto r = recurrence(2.0 * std::numbers::pi / period, damping, step);
  double u = 0.0, v = 0.0;
  const auto advance = [&](double a0, double a1) {
    const double next = r.a11 * u + r.a12 * v + r.b11 * a0 + r.b12 * a1;
    v = r.a21 * u + r.a22 * v + r.b21 * a0 + r.b22 * a1;
    u = next;
    visit(u, v, a1);
  };
  visit(u, v, acceleration[0]);
  for (std::size_t i = 0; i + 1 < acceleration.size(); ++i) {
    const double slope = (acceleration[i + 1] - acceleration[i]) / static_cast<double>(pieces);
    for (std::size_t k = 0; k < pieces; ++k) {
      const double a0 = acceleration[i] + slope * static_cast<double>(k);
      advance(a0, a0 + slope);
    }
  }
  const auto free_steps = static_cast<std::size_t>(std::ceil(period / step));
  for (std::size_t k = 0; k < free_steps; ++k) advance(0.0, 0.0);
}

void require_oscillator(double period, double damping) {
  if (!(period > 0.0) || !(damping >= 0.0) || !(damping < 1.0))
    throw Error(ErrorCode::invalid_argument, "an oscillator needs a period above 0 and a damping in 0..1");
}

}  // namespace

GroundMotionMeasures measures(std::span<const double> acceleration, double dt) {
  require_series(acceleration, dt);
  GroundMotionMeasures m;
  double v = 0.0, d = 0.0;
  m.pga_m_s2 = std::abs(acceleration[0]);
  for (std::size_t i = 1; i < acceleration.size(); ++i) {
    const double next = v + 0.5 * dt * (acceleration[i - 1] + acceleration[i]);
    d += 0.5 * dt * (v + next);
    v = next;
    m.pga_m_s2 = std::max(m.pga_m_s2, std::abs(acceleration[i]));
    m.pgv_m_s = std::max(m.pgv_m_s, std::abs(v));
    m.pgd_m = std::max(m.pgd_m, std::abs(d));
  }
  m.final_velocity_m_s = v;
  m.duration_s = dt * static_cast<double>(acceleration.size() - 1);
  return m;
}

SpectralOrdinate spectral_ordinate(std::span<const double> acceleration, double dt, double period, double damping) {
  require_series(acceleration, dt);
  require_oscillator(period, damping);
  const double w = 2.0 * std::numbers::pi / period;
  SpectralOrdinate s;
  run_oscillator(acceleration, dt, period, damping, [&](double u, double v, double) {
    s.displacement = std::max(s.displacement, std::abs(u));
    s.absolute_acceleration = std::max(s.absolute_acceleration, std::abs(2.0 * damping * w * v + w * w * u));
  });
  s.pseudo_acceleration = w * w * s.displacement;
  return s;
}

double rotd50(std::span<const double> first, std::span<const double> second, double dt, double period, double damping) {
  require_series(first, dt);
  require_series(second, dt);
  const std::size_t n = std::min(first.size(), second.size());
  std::vector<double> a, b;
  if (period > 0.0) {
    require_oscillator(period, damping);
    run_oscillator(first.first(n), dt, period, damping, [&](double u, double, double) { a.push_back(u); });
    run_oscillator(second.first(n), dt, period, damping, [&](double u, double, double) { b.push_back(u); });
  } else {
    a.assign(first.begin(), first.begin() + static_cast<std::ptrdiff_t>(n));
    b.assign(second.begin(), second.begin() + static_cast<std::ptrdiff_t>(n));
  }
  std::array<double, 180> peaks{};
  for (std::size_t k = 0; k < peaks.size(); ++k) {
    const double angle = std::numbers::pi * static_cast<double>(k) / 180.0;
    const double c = std::cos(angle), s = std::sin(angle);
    for (std::size_t i = 0; i < a.size(); ++i) peaks[k] = std::max(peaks[k], std::abs(c * a[i] + s * b[i]));
  }
  std::sort(peaks.begin(), peaks.end());
  const double median = 0.5 * (peaks[89] + peaks[90]);
  const double w = period > 0.0 ? 2.0 * std::numbers::pi / period : 1.0;
  return w * w * median;
}

Pulse one_cosine(double pga, double pgv_over_pga, std::size_t samples) {
  if (!(pga > 0.0) || !(pgv_over_pga > 0.0) || samples < 50)
    throw Error(ErrorCode::invalid_argument, "a cosine pulse needs positive PGA and PGV/PGA and 50 samples a period");
  const double period = 2.0 * std::numbers::pi * pgv_over_pga;
  Pulse pulse{period / static_cast<double>(samples), {}};
  for (std::size_t i = 0; i <= samples; ++i)
    pulse.acceleration.push_back(
        pga * std::cos(2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(samples)));
  return pulse;
}

Pulse half_sine(double amplitude, double omega, std::size_t samples) {
  if (!(omega > 0.0) || samples < 50)
    throw Error(ErrorCode::invalid_argument, "a half sine needs a positive frequency and 50 samples");
  Pulse pulse{std::numbers::pi / omega / static_cast<double>(samples), {}};
  for (std::size_t i = 0; i <= samples; ++i)
    pulse.acceleration.push_back(amplitude *
                                 std::sin(std::numbers::pi * static_cast<double>(i) / static_cast<double>(samples)));
  return pulse;
}

Pulse rectangular_pulse(double amplitude, double duration) {
  if (!(duration > 0.0)) throw Error(ErrorCode::invalid_argument, "a pulse needs a positive duration");
  return {duration / 50.0, std::vector<double>(51, amplitude)};
}

}  // namespace cairn::fragility
