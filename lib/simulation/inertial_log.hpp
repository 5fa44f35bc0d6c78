// The inertial log that a ground vehicle would have recorded on a known drive.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/options.hpp"
#include "base/random.hpp"
#include "survey/ground_vehicle.hpp"

namespace cairn::simulation {

// Errors of an aided inertial navigation (INS with GPS, paper B: about 1.5 m off when it stands). "Drifting" errors are
// first-order Gauss-Markov: stationary standard deviation and correlation time.
struct InertialErrors {
  double velocity_noise_m_s = 0.05;  // white, per sample and axis, 1 sigma
  double bias_sigma_m_s = 0.02;      // drifting velocity bias per axis (east, north), 1 sigma
  double bias_time_s = 100.0;
  double heading_sigma_deg = 1.0;  // drifting heading error, 1 sigma; the velocity is turned with it
  double heading_time_s = 100.0;
  double position_sigma_m = 1.06;  // drifting error of the log's position per axis (1.5 m in the plane), 1 sigma
  double position_time_s = 60.0;

  void visit(base::OptionVisitor& visitor);
};

// Makes the log sample by sample; deterministic by the generator it is given.
class InertialLog {
 public:
  InertialLog(const InertialErrors& errors, base::Random random);

  // truth: the vehicle at a time later than the one before; its covariance is ignored. The sample's covariance is that
  // of the log's position. Its velocity is the true one turned by the heading error, with bias and noise.
  [[nodiscard]] survey::VehicleState sample(const survey::VehicleState& truth);

 private:
  InertialErrors errors_;
  base::Random random_;
  bool first_ = true;
  std::int64_t time_ns_ = 0;
  geometry::Vec2 bias_ = geometry::Vec2::Zero(), offset_ = geometry::Vec2::Zero();
  double heading_ = 0.0;  // rad
};

// The same for a whole drive, ascending times.
[[nodiscard]] std::vector<survey::VehicleState> inertial_log(std::span<const survey::VehicleState> truth,
                                                             const InertialErrors& errors, base::Random random);

}  // namespace cairn::simulation
