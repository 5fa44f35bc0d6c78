// The plane rocking of a rigid block, by Runge-Kutta with located impacts: the oracle of the three-dimensional runs.
#pragma once

#include <cmath>
#include <functional>

namespace cairn::testing {

constexpr double kG = 9.80665;

// fragility.md 2.2: rectangle of half width b, half height h, centre of mass in its middle.
struct PlaneBlock {
  double b = 0.0, h = 0.0;
  [[nodiscard]] double alpha() const { return std::atan2(b, h); }
  [[nodiscard]] double r() const { return std::hypot(b, h); }
  [[nodiscard]] double p() const { return std::sqrt(3.0 * kG / (4.0 * r())); }
  [[nodiscard]] double eta() const { return 1.0 - 1.5 * std::pow(std::sin(alpha()), 2); }
  // Least velocity step (fragility.md 2.3).
  [[nodiscard]] double v_min() const { return 2.0 * kG / p() * std::sin(alpha() / 2) / std::cos(alpha()); }
};

struct PlaneOutcome {
  bool toppled = false;
  double greatest = 0.0;  // |theta|, rad
};

// theta > 0 tips towards +x; a_x: ground acceleration [m/s^2] along +x. Starts at theta0, theta_dot0.
inline PlaneOutcome rock_plane(const PlaneBlock& block, const std::function<double(double)>& a_x, double end,
                               double theta0 = 0.0, double rate0 = 0.0, double dt = 1e-4) {
  const double alpha = block.alpha(), p2 = block.p() * block.p();
  double theta = theta0, rate = rate0, t = 0.0;
  // Ground acceleration towards +x pushes towards -x.
  const auto f = [&](double time, double th, double side) {
    return -p2 * (std::sin(alpha * side - th) + a_x(time) / kG * std::cos(alpha * side - th));
  };
  PlaneOutcome out;
  for (; t < end; t += dt) {
    double side = theta > 0.0 || (theta == 0.0 && rate > 0.0) ? 1.0 : -1.0;
    if (theta == 0.0 && rate == 0.0) {
      const double a = a_x(t) / kG;
      if (std::abs(a) <= std::tan(alpha)) continue;
      side = a > 0.0 ? -1.0 : 1.0;
    }
    const double k1v = f(t, theta, side), k1x = rate;
    const double k2v = f(t + dt / 2, theta + dt / 2 * k1x, side), k2x = rate + dt / 2 * k1v;
    const double k3v = f(t + dt / 2, theta + dt / 2 * k2x, side), k3x = rate + dt / 2 * k2v;
    const double k4v = f(t + dt, theta + dt * k3x, side), k4x = rate + dt * k3v;
    const double next = theta + dt / 6 * (k1x + 2 * k2x + 2 * k3x + k4x);
    double next_rate = rate + dt / 6 * (k1v + 2 * k2v + 2 * k3v + k4v);
    if (next * side < 0.0) {
      next_rate *= block.eta();
      theta = 0.0;
      rate = std::abs(next_rate) < 1e-5 ? 0.0 : next_rate;
    } else {
      theta = next;
      rate = next_rate;
    }
    out.greatest = std::max(out.greatest, std::abs(theta));
    if (std::abs(theta) > 1.4) {
      out.toppled = true;
      return out;
    }
  }
  return out;
}

}  // namespace cairn::testing
