#include "fragility/pulse_criteria.hpp"

#include <cmath>
#include <numbers>

#include "base/error.hpp"
#include "fragility/tipping.hpp"

namespace cairn::fragility {
namespace {

void require(bool ok, const char* what) {
  if (!ok) throw base::Error(base::ErrorCode::invalid_argument, what);
}

}  // namespace

double velocity_step(double alpha, double p, bool slender) {
  require(alpha > 0.0 && alpha < 0.5 * std::numbers::pi && p > 0.0, "a velocity step needs 0 < alpha < pi/2 and p > 0");
  return slender ? kGravity * alpha / p : 2.0 * kGravity / p * std::sin(0.5 * alpha) / std::cos(alpha);
}

double rectangular_pulse_ratio(double p, double t1) {
  require(p > 0.0 && t1 > 0.0, "a rectangular pulse needs p > 0 and a positive duration");
  return -1.0 / std::expm1(-p * t1);
}

double half_sine_ratio(double q) {
  require(q > 0.0, "a half sine needs omega / p > 0");
  // The difference is negative at 0 and positive at pi/2: q > exp(-pi / (2 q)) because q ln q >= -1/e > -pi/2.
  const auto f = [q](double psi) {
    return q * std::sin(psi) - std::cos(psi) - std::exp(-(std::numbers::pi - psi) / q);
  };
  double lo = 0.0, hi = 0.5 * std::numbers::pi;
  for (int i = 0; i < 100 && hi - lo > 1e-15; ++i) {
    const double mid = 0.5 * (lo + hi);
    (f(mid) > 0.0 ? hi : lo) = mid;
  }
  return 1.0 / std::sin(0.5 * (lo + hi));
}

double half_sine_ratio_housner(double q) {
  require(q > 0.0, "a half sine needs omega / p > 0");
  return std::sqrt(1.0 + q * q);
}

double quarter_period_times_p(double r) {
  require(r > 0.0 && r < 1.0, "free rocking needs 0 < theta_0 / alpha < 1");
  return std::acosh(1.0 / (1.0 - r));
}

double rectangle_restitution(double alpha) {
  const double s = std::sin(alpha);
  return 1.0 - 1.5 * s * s;
}

}  // namespace cairn::fragility
