#include "ground/vehicle_track.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/error.hpp"

namespace cairn::ground {
namespace {

constexpr double kTolerance = 1e-12;  // m and rad

survey::VehicleState state(std::int64_t time_ns, double east, double yaw) {
  survey::VehicleState s;
  s.time_ns = time_ns;
  s.position = {east, 1.0};
  s.yaw = yaw;
  return s;
}

TEST(VehicleTrack, InterpolatesTheShorterWayRound) {
  const double almost = std::numbers::pi - 0.1;
  const std::vector<survey::VehicleState> states{state(100, 0.0, almost), state(200, 2.0, -almost),
                                                 state(1'000'000'000, 9.0, 0.0)};
  const VehicleTrack track(states, 0.5);
  const auto middle = track.at(150);
  ASSERT_TRUE(middle);
  EXPECT_NEAR(middle->position.x(), 1.0, kTolerance);
  EXPECT_NEAR(std::cos(middle->yaw), -1.0, kTolerance);
  EXPECT_EQ(track.at(200)->position.x(), 2.0);
  EXPECT_EQ(track.at(1'000'000'000)->position.x(), 9.0);
  EXPECT_FALSE(track.at(99));
  EXPECT_FALSE(track.at(500)) << "inside a gap";
  EXPECT_FALSE(track.at(1'000'000'001));
}

TEST(VehicleTrack, TiltIsThatOfTheLinesAround) {
  std::vector<survey::VehicleState> states{state(0, 0.0, 0.0), state(100, 0.0, 0.0)};
  states[1].pitch = -0.2;
  const VehicleTrack track(states, 1.0);
  EXPECT_EQ(track.tilt(50), 0.2);
  EXPECT_EQ(track.tilt(500), 0.0);
}

TEST(VehicleTrack, RefusesTimesThatDoNotAscend) {
  const std::vector<survey::VehicleState> states{state(100, 0.0, 0.0), state(100, 0.0, 0.0)};
  EXPECT_THROW(VehicleTrack(states, 1.0), base::Error);
  EXPECT_FALSE(VehicleTrack({}, 1.0).at(0));
}

}  // namespace
}  // namespace cairn::ground
