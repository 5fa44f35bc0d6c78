#include "ground/skid_steer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace cairn::ground {
namespace {

constexpr double kTol = 1e-12;  // m, rad: rounding of one closed form

TEST(SkidSteer, WheelsAndVelocityAreInverse) {
  const SkidSteerOptions options;
  const DriveVelocity velocity{0.7, -0.4};
  const auto wheels = wheel_speeds(velocity, options);
  // v -+ w ratio track / 2
  EXPECT_NEAR(wheels.left_m_s, 0.7 + 0.4 * 1.5 * 0.37 / 2.0, kTol);
  EXPECT_NEAR(wheels.right_m_s, 0.7 - 0.4 * 1.5 * 0.37 / 2.0, kTol);
  const auto back = velocity_of(wheels, options);
  EXPECT_NEAR(back.forward_m_s, velocity.forward_m_s, kTol);
  EXPECT_NEAR(back.turn_rad_s, velocity.turn_rad_s, kTol);
}

TEST(SkidSteer, MovesOnArcs) {
  // A quarter of a circle of radius 2 to the left, then straight on.
  const auto quarter = moved({{1.0, 1.0}, 0.0}, {1.0, 0.5}, std::numbers::pi);
  EXPECT_NEAR(quarter.position.x(), 3.0, kTol);
  EXPECT_NEAR(quarter.position.y(), 3.0, kTol);
  EXPECT_NEAR(quarter.yaw, std::numbers::pi / 2.0, kTol);
  const auto on = moved(quarter, {1.0, 0.0}, 2.0);
  EXPECT_NEAR(on.position.y(), 5.0, kTol);
  // The series for slight turns meets the closed form.
  const auto slight = moved({}, {1.0, 2.1e-6}, 1.0), slighter = moved({}, {1.0, 1.9e-6}, 1.0);
  EXPECT_NEAR(slight.position.y(), 1.05e-6, kTol);
  EXPECT_NEAR(slighter.position.y(), 0.95e-6, kTol);
  EXPECT_NEAR(moved({{0.0, 0.0}, 3.0}, {0.0, 1.0}, 1.0).yaw, 4.0 - 2.0 * std::numbers::pi, kTol);
}

TEST(SkidSteer, KeepsLimitsAndCurvature) {
  SkidSteerOptions options;
  options.max_wheel_speed_m_s = 1.1;
  const auto cut = within_limits({5.0, 9.0}, options);
  EXPECT_NEAR(cut.forward_m_s / cut.turn_rad_s, options.max_speed_m_s / options.max_turn_rad_s, kTol);
  EXPECT_NEAR(wheel_speeds(cut, options).right_m_s, 1.1, kTol);
  EXPECT_DOUBLE_EQ(within_limits({-5.0, 0.0}, options).forward_m_s, -options.max_reverse_m_s);
}

TEST(SkidSteer, AcceleratesAndBrakesWithinItsPower) {
  const SkidSteerOptions options;
  EXPECT_NEAR(approach({0.2, 0.0}, {1.0, 1.0}, 0.1, options).forward_m_s, 0.3, kTol);
  EXPECT_NEAR(approach({0.2, 0.0}, {1.0, 1.0}, 0.1, options).turn_rad_s, 0.3, kTol);
  EXPECT_NEAR(approach({0.8, 0.0}, {0.0, 0.0}, 0.1, options).forward_m_s, 0.6, kTol);
  EXPECT_NEAR(approach({0.05, 0.0}, {0.0, 0.0}, 0.1, options).forward_m_s, 0.0, kTol);
  EXPECT_NEAR(braking_distance(1.0, options), 0.25, kTol);
}

}  // namespace
}  // namespace cairn::ground
