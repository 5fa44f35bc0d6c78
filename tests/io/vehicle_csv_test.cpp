#include "io/vehicle_csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "support/data.hpp"

namespace {

using namespace cairn;
using cairn::testing::TempFolder;
using ::testing::HasSubstr;

constexpr double kAngle = 1e-12;  // rad: two conversions between degrees and radians
constexpr const char* kHeader = "time_ns,x_m,y_m,vx_m_s,vy_m_s,roll_deg,pitch_deg,heading_deg";

class VehicleCsv : public ::testing::Test {
 protected:
  TempFolder folder_;
  std::filesystem::path path_ = folder_ / "vehicle.csv";

  [[nodiscard]] std::string refusal(const std::string& content) const {
    base::write_file(path_, content);
    try {
      static_cast<void>(io::read_vehicle_csv(path_));
    } catch (const base::Error& e) {
      return e.what();
    }
    return "accepted";
  }
};

TEST_F(VehicleCsv, RoundTrip) {
  std::vector<survey::VehicleState> states;
  for (int i = 0; i < 40; ++i) {
    survey::VehicleState s;
    s.time_ns = 20'000'000LL * i - 300;
    s.position = {0.1 * i, 1.0 / (i + 3.0)};
    s.velocity = {std::cos(i), std::sin(i)};
    s.roll = 0.01 * i;
    s.pitch = -0.02 * i;
    s.yaw = std::remainder(0.3 * i, 2 * std::numbers::pi);
    if (i % 2 == 1) s.covariance = (geometry::Mat2() << 0.3, 0.1, 0.1, 0.2).finished();
    states.push_back(s);
  }
  io::write_vehicle_csv(path_, states);
  const auto back = io::read_vehicle_csv(path_);
  ASSERT_EQ(back.size(), states.size());
  for (std::size_t i = 0; i < back.size(); ++i) {
    EXPECT_EQ(back[i].time_ns, states[i].time_ns);
    EXPECT_EQ(back[i].position, states[i].position);
    EXPECT_EQ(back[i].velocity, states[i].velocity);
    EXPECT_NEAR(back[i].roll, states[i].roll, kAngle);
    EXPECT_NEAR(back[i].pitch, states[i].pitch, kAngle);
    EXPECT_NEAR(std::remainder(back[i].yaw - states[i].yaw, 2 * std::numbers::pi), 0.0, kAngle);
    EXPECT_EQ(back[i].covariance.has_value(), states[i].covariance.has_value());
    EXPECT_EQ(back[i].covariance.value_or(geometry::Mat2::Zero()),
              states[i].covariance.value_or(geometry::Mat2::Zero()));
  }
}

TEST_F(VehicleCsv, HeadingIsClockwiseFromNorth) {
  base::write_file(path_, std::string(kHeader) + "\n0,0,0,0,0,0,0,0\n1,0,0,0,0,0,0,90\n2,0,0,0,0,0,0,315\n");
  const auto states = io::read_vehicle_csv(path_);
  ASSERT_EQ(states.size(), 3U);
  EXPECT_NEAR(states[0].yaw, std::numbers::pi / 2, kAngle);      // north
  EXPECT_NEAR(states[1].yaw, 0.0, kAngle);                       // east
  EXPECT_NEAR(states[2].yaw, 3 * std::numbers::pi / 4, kAngle);  // north-west
}

TEST_F(VehicleCsv, VariancesMayBeMissing) {
  base::write_file(path_, std::string(kHeader) + "\n0,1,2,3,4,5,6,7\n");
  EXPECT_FALSE(io::read_vehicle_csv(path_).at(0).covariance);
  base::write_file(
      path_, std::string(kHeader) + ",var_xx_m2,var_xy_m2,var_yy_m2\n0,1,2,3,4,5,6,7,,,\n1,1,2,3,4,5,6,7,4,1,9\n");
  const auto states = io::read_vehicle_csv(path_);
  EXPECT_FALSE(states.at(0).covariance);
  ASSERT_TRUE(states.at(1).covariance);
  EXPECT_EQ((*states[1].covariance)(1, 1), 9.0);
}

TEST_F(VehicleCsv, Refusals) {
  const std::string header = std::string(kHeader) + ",var_xx_m2,var_xy_m2,var_yy_m2\n";
  EXPECT_THAT(refusal("time_ns,x_m\n0,1\n"), HasSubstr("y_m"));
  EXPECT_THAT(refusal(header + "0,nan,2,3,4,5,6,7,,,\n"), HasSubstr("x_m"));
  EXPECT_THAT(refusal(header + "5,1,2,3,4,5,6,7,,,\n5,1,2,3,4,5,6,7,,,\n"), HasSubstr("do not ascend"));
  EXPECT_THAT(refusal(header + "0,1,2,3,4,5,6,7,1,,1\n"), HasSubstr("lacks an element"));
  EXPECT_THAT(refusal(header + "0,1,2,3,4,5,6,7,1,2,1\n"), HasSubstr("not positive semi-definite"));
  EXPECT_THAT(refusal(header + "0,1,2,3,4,5,6,7,-1,0,1\n"), HasSubstr("not positive semi-definite"));
}

TEST_F(VehicleCsv, WhatIsNotFiniteIsNotWritten) {
  survey::VehicleState s;
  s.velocity.x() = std::numeric_limits<double>::infinity();
  EXPECT_THROW(io::write_vehicle_csv(path_, std::vector{s}), base::Error);
}

}  // namespace
