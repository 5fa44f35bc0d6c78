#include "planning/trajectory.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/random.hpp"

namespace {

using cairn::planning::evaluate;
using cairn::planning::FlightKey;
using cairn::planning::plan_flight;
using cairn::planning::Pose4;
using cairn::planning::TrajectoryOptions;

struct Sampled {
  double speed = 0.0, acceleration = 0.0, yaw_rate_deg_s = 0.0;
};

Sampled sample_each_ms(const std::vector<cairn::survey::PolynomialSegment>& trajectory) {
  Sampled s;
  for (const auto& segment : trajectory)
    for (double t = 0.0; t < segment.duration_s; t += 0.001) {
      const Pose4 v = evaluate(segment, t, 1);
      s.speed = std::max(s.speed, v.head<3>().norm());
      s.acceleration = std::max(s.acceleration, evaluate(segment, t, 2).head<3>().norm());
      s.yaw_rate_deg_s = std::max(s.yaw_rate_deg_s, cairn::base::rad_to_deg(std::abs(v.w())));
    }
  return s;
}

// Paper oracle (section 8): d = 10 m, v = a = 1.
TEST(Trajectory, NominalDurationOfThePublishedPlanner) {
  EXPECT_NEAR(cairn::planning::nominal_duration(10.0, 1.0, 1.0), 20.0, 1e-5);
}

TEST(Trajectory, KeepsItsLimitsOnOneMillisecondSamples) {
  for (std::uint64_t run = 0; run < 20; ++run) {
    cairn::base::Random random(11, "flight", run);
    TrajectoryOptions options;
    options.max_speed_m_s = random.uniform(0.3, 6.0);
    options.max_acceleration_m_s2 = random.uniform(0.3, 3.0);
    options.max_yaw_rate_deg_s = random.uniform(10.0, 90.0);
    std::vector<FlightKey> keys(3 + random.below(8));
    for (auto& key : keys) {
      key.pose = {random.uniform(-30, 30), random.uniform(-30, 30), random.uniform(5, 20), random.uniform(-4, 4)};
      key.stop = random.uniform() < 0.3;
    }
    const auto flight = plan_flight(keys, options);
    const auto s = sample_each_ms(flight.trajectory);
    EXPECT_LE(s.speed, options.max_speed_m_s) << "run " << run;
    EXPECT_LE(s.acceleration, options.max_acceleration_m_s2) << "run " << run;
    EXPECT_LE(s.yaw_rate_deg_s, options.max_yaw_rate_deg_s) << "run " << run;
    // The reported peaks bound the samples, and one limit is used up in each stretch.
    EXPECT_GE(flight.peaks.speed_m_s * (1 + 1e-12), s.speed);
    EXPECT_GE(flight.peaks.acceleration_m_s2 * (1 + 1e-12), s.acceleration);
    EXPECT_LE(flight.peaks.speed_m_s, 1.001 * std::max(s.speed, 1e-9));
    EXPECT_GT(std::max({s.speed / options.max_speed_m_s, s.acceleration / options.max_acceleration_m_s2,
                        s.yaw_rate_deg_s / options.max_yaw_rate_deg_s}),
              0.99);
    for (std::size_t i = 0; i < keys.size(); ++i)
      EXPECT_LT((evaluate(flight.trajectory, flight.key_times_s[i]) - keys[i].pose).norm(), 1e-5);
  }
}

// The published durations overrun the limits at corners, and say so.
TEST(Trajectory, PaperModeReportsWhatItDoesNotEnforce) {
  TrajectoryOptions options;
  options.mode = "paper";
  const std::vector<FlightKey> keys{
      {{0, 0, 0, 0}, true}, {{1, 0, 0, 0}, false}, {{1, 20, 0, 0}, false}, {{0, 20, 0, 0}, true}};
  const auto paper = plan_flight(keys, options);
  EXPECT_NEAR(paper.peaks.speed_m_s, sample_each_ms(paper.trajectory).speed, 1e-4);
  EXPECT_GT(paper.peaks.speed_m_s, options.max_speed_m_s);
  EXPECT_NEAR(paper.key_times_s[1], cairn::planning::nominal_duration(1, 1, 1), 1e-12);
  options.mode = "robust";
  EXPECT_LE(plan_flight(keys, options).peaks.speed_m_s, options.max_speed_m_s);
}

// Stop to stop is a straight line, flown nearly as fast as a bang-bang profile allows.
TEST(Trajectory, ALegFromStopToStopIsStraightAndCruises) {
  TrajectoryOptions options;
  options.max_speed_m_s = 3.0;
  const std::vector<FlightKey> keys{{{0, 0, 10, 0}, true}, {{100, 50, 10, 0}, true}};
  const auto flight = plan_flight(keys, options);
  const double length = std::hypot(100.0, 50.0);
  const double fastest = length / 3.0 + 3.0 / 1.0;
  const double time = cairn::planning::duration(flight.trajectory);
  EXPECT_GT(time, fastest);
  // The ramps are 2.19 times as long as those of constant acceleration.
  EXPECT_LT(time, length / 3.0 + 2.19 * 3.0 + 0.01);
  for (double t = 0; t < time; t += 0.5) {
    const Pose4 p = evaluate(flight.trajectory, t);
    EXPECT_NEAR(p.x() * 50 - p.y() * 100, 0.0, 1e-6);
    EXPECT_NEAR(p.z(), 10.0, 1e-9);
  }
}

TEST(Trajectory, PausesTurnsOnTheSpotAndRefusals) {
  const TrajectoryOptions options;
  const FlightKey here{{1, 2, 3, 0}, true};
  EXPECT_TRUE(plan_flight(std::vector<FlightKey>{here}, options).trajectory.empty());
  EXPECT_TRUE(plan_flight(std::vector<FlightKey>{here, here}, options).trajectory.empty());
  FlightKey turned = here;
  turned.pose.w() = std::numbers::pi;
  const auto turn = plan_flight(std::vector<FlightKey>{here, turned}, options);
  EXPECT_GT(cairn::planning::duration(turn.trajectory), 180.0 / options.max_yaw_rate_deg_s);
  EXPECT_LE(turn.peaks.yaw_rate_deg_s, options.max_yaw_rate_deg_s);
  EXPECT_THROW(static_cast<void>(plan_flight(std::vector<FlightKey>{}, options)), cairn::base::Error);
  turned.pose.x() = std::nan("");
  EXPECT_THROW(static_cast<void>(plan_flight(std::vector<FlightKey>{here, turned}, options)), cairn::base::Error);
  TrajectoryOptions wrong;
  wrong.max_speed_m_s = 0.0;
  EXPECT_THROW(static_cast<void>(plan_flight(std::vector<FlightKey>{here}, wrong)), cairn::base::Error);
}

}  // namespace
