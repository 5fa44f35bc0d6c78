#include "simulation/inertial_log.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace {

using namespace cairn;
using geometry::Vec2;
using simulation::InertialErrors;

constexpr std::int64_t kStep_ns = 20'000'000;

std::vector<survey::VehicleState> straight(std::size_t count, const Vec2& velocity) {
  std::vector<survey::VehicleState> truth(count);
  for (std::size_t i = 0; i < count; ++i) {
    truth[i].time_ns = static_cast<std::int64_t>(i) * kStep_ns;
    truth[i].position = velocity * (0.02 * static_cast<double>(i));
    truth[i].velocity = velocity;
    truth[i].yaw = std::atan2(velocity.y(), velocity.x());
  }
  return truth;
}

TEST(InertialLog, ErrorsHaveTheirSizes) {
  // Pooled over 40 logs of 10 minutes: 6 correlation times each.
  double velocity = 0.0, position = 0.0, heading = 0.0, noise = 0.0;
  std::size_t count = 0;
  const InertialErrors errors;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const auto truth = straight(30000, {1.0, 0.0});
    const auto log = simulation::inertial_log(truth, errors, base::Random(seed, "inertial_log_test", 0));
    for (std::size_t i = 1; i < log.size(); i += 10) {
      const Vec2 error = log[i].velocity - truth[i].velocity;
      velocity += error.x() * error.x();
      position += 0.5 * (log[i].position - truth[i].position).squaredNorm();
      heading += log[i].yaw * log[i].yaw;
      noise += 0.5 * (log[i].velocity - log[i - 1].velocity).x() * (log[i].velocity - log[i - 1].velocity).x();
      ++count;
    }
  }
  const auto rms = [&](double squares) { return std::sqrt(squares / static_cast<double>(count)); };
  constexpr double kShare = 0.15;  // some 240 independent values: 5 % of the sigma, three times
  EXPECT_NEAR(rms(noise), 0.05, 0.05 * 0.02);
  EXPECT_NEAR(rms(velocity), std::hypot(0.05, 0.02), 0.05 * kShare);
  EXPECT_NEAR(rms(position), 1.06, 1.06 * kShare);
  EXPECT_NEAR(rms(heading), std::numbers::pi / 180.0, kShare * std::numbers::pi / 180.0);
}

TEST(InertialLog, TheHeadingErrorTurnsTheVelocity) {
  InertialErrors errors;
  errors.velocity_noise_m_s = errors.bias_sigma_m_s = errors.position_sigma_m = 0.0;
  const auto truth = straight(1000, {0.6, 0.8});
  const auto log = simulation::inertial_log(truth, errors, base::Random(1, "inertial_log_test", 0));
  constexpr double kRounding = 1e-12;
  for (std::size_t i = 0; i < log.size(); ++i) {
    EXPECT_NEAR(log[i].velocity.norm(), 1.0, kRounding);
    EXPECT_NEAR(std::atan2(log[i].velocity.y(), log[i].velocity.x()), log[i].yaw, kRounding);
    EXPECT_EQ(log[i].position, truth[i].position);
  }
  EXPECT_NE(log[0].yaw, truth[0].yaw);
}

TEST(InertialLog, NoErrorsNoChange) {
  InertialErrors errors;
  errors.velocity_noise_m_s = errors.bias_sigma_m_s = errors.heading_sigma_deg = errors.position_sigma_m = 0.0;
  const auto truth = straight(100, {0.6, 0.8});
  const auto log = simulation::inertial_log(truth, errors, base::Random(1, "inertial_log_test", 0));
  for (std::size_t i = 0; i < log.size(); ++i) EXPECT_EQ(log[i].velocity, truth[i].velocity);
}

TEST(InertialLog, DriftDoesNotDependOnTheRate) {
  // Sampled at 50 Hz and at 1 Hz, a drift has the same correlation over 10 s.
  const auto correlation = [](std::size_t step) {
    InertialErrors errors;
    errors.velocity_noise_m_s = errors.heading_sigma_deg = 0.0;
    errors.bias_time_s = 10.0;
    double product = 0.0, square = 0.0;
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
      std::vector<survey::VehicleState> truth;
      for (const auto& s : straight(20001, {0, 0}))
        if (static_cast<std::size_t>(s.time_ns / kStep_ns) % step == 0) truth.push_back(s);
      const auto log = simulation::inertial_log(truth, errors, base::Random(seed, "inertial_log_test", step));
      const std::size_t lag = 500 / step;
      for (std::size_t i = 0; i + lag < log.size(); ++i) {
        product += log[i].velocity.dot(log[i + lag].velocity);
        square += log[i].velocity.squaredNorm();
      }
    }
    return product / square;
  };
  constexpr double kCorrelation = 0.08;  // some 5000 independent values, correlated among themselves
  EXPECT_NEAR(correlation(1), std::exp(-1.0), kCorrelation);
  EXPECT_NEAR(correlation(50), std::exp(-1.0), kCorrelation);
}

}  // namespace
