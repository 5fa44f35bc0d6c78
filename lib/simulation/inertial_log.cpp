#include "simulation/inertial_log.hpp"

#include <cmath>
#include <numbers>

#include "base/angle.hpp"

namespace cairn::simulation {

using geometry::Vec2;

void InertialErrors::visit(base::OptionVisitor& v) {
  v.real("ins-velocity-noise-m-s", velocity_noise_m_s, 0.0, 100.0, "noise of the inertial velocity, 1 sigma");
  v.real("ins-bias-sigma-m-s", bias_sigma_m_s, 0.0, 100.0, "drifting bias of the inertial velocity, 1 sigma per axis");
  v.real("ins-bias-time-s", bias_time_s, 1e-2, 1e9, "correlation time of that bias");
  v.real("ins-heading-sigma-deg", heading_sigma_deg, 0.0, 180.0, "drifting heading error, 1 sigma");
  v.real("ins-heading-time-s", heading_time_s, 1e-2, 1e9, "correlation time of that error");
  v.real("ins-position-sigma-m", position_sigma_m, 0.0, 1e4, "drifting error of the log's position, 1 sigma per axis");
  v.real("ins-position-time-s", position_time_s, 1e-2, 1e9, "correlation time of that error");
}

InertialLog::InertialLog(const InertialErrors& errors, base::Random random) : errors_(errors), random_(random) {}

survey::VehicleState InertialLog::sample(const survey::VehicleState& truth) {
  const double dt = first_ ? 0.0 : static_cast<double>(truth.time_ns - time_ns_) * 1e-9;
  const double heading_sigma = base::deg_to_rad(errors_.heading_sigma_deg);
  // Gauss-Markov, exact for any step; the first sample is drawn from the stationary distribution.
  const auto drift = [&](double value, double sigma, double time_s) {
    const double keep = first_ ? 0.0 : std::exp(-dt / time_s);
    return keep * value + sigma * std::sqrt(1.0 - keep * keep) * random_.normal();
  };
  for (int a = 0; a < 2; ++a) bias_[a] = drift(bias_[a], errors_.bias_sigma_m_s, errors_.bias_time_s);
  heading_ = drift(heading_, heading_sigma, errors_.heading_time_s);
  for (int a = 0; a < 2; ++a) offset_[a] = drift(offset_[a], errors_.position_sigma_m, errors_.position_time_s);
  first_ = false;
  time_ns_ = truth.time_ns;

  survey::VehicleState s = truth;
  const double c = std::cos(heading_), n = std::sin(heading_);
  s.position = truth.position + offset_;
  s.velocity =
      Vec2(c * truth.velocity.x() - n * truth.velocity.y(), n * truth.velocity.x() + c * truth.velocity.y()) + bias_;
  for (int a = 0; a < 2; ++a) s.velocity[a] += errors_.velocity_noise_m_s * random_.normal();
  s.yaw = std::remainder(truth.yaw + heading_, 2.0 * std::numbers::pi);
  s.covariance = errors_.position_sigma_m * errors_.position_sigma_m * geometry::Mat2::Identity();
  return s;
}

std::vector<survey::VehicleState> inertial_log(std::span<const survey::VehicleState> truth,
                                               const InertialErrors& errors, base::Random random) {
  InertialLog log(errors, random);
  std::vector<survey::VehicleState> samples;
  samples.reserve(truth.size());
  for (const auto& state : truth) samples.push_back(log.sample(state));
  return samples;
}

}  // namespace cairn::simulation
