#include "io/vehicle_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "support/data.hpp"

namespace {

using namespace cairn;
using cairn::testing::TempFolder;
using cairn::testing::test_data;
using ::testing::HasSubstr;

constexpr double kMetre = 1e-9;   // printed decimals
constexpr double kAngle = 1e-12;  // rad

class VehicleLogFile : public ::testing::Test {
 protected:
  TempFolder folder_;
  std::filesystem::path path_ = folder_ / "log.txt";

  [[nodiscard]] io::VehicleLog read(const std::string& content, const std::string& format = "auto") const {
    base::write_file(path_, content);
    return io::read_vehicle_log(path_, format);
  }
  [[nodiscard]] std::string refusal(const std::string& content, const std::string& format = "auto") const {
    try {
      static_cast<void>(read(content, format));
    } catch (const base::Error& e) {
      return e.what();
    }
    return "accepted";
  }
};

TEST(VehicleLogs, PlazaMowerOdometry) {
  const auto log = io::read_vehicle_log(test_data("plaza/Plaza1_DR.txt"));
  EXPECT_EQ(log.format, "plaza");
  EXPECT_EQ(log.samples.size() + log.rejects.size(), 9657U);
  EXPECT_EQ(log.samples.front().time_ns, 3'857'053'201'914LL);
  double way = 0.0;
  for (std::size_t i = 1; i < log.samples.size(); ++i) {
    way += (log.samples[i].position - log.samples[i - 1].position).norm();
    ASSERT_TRUE(log.samples[i].velocity.allFinite());
    ASSERT_LT(log.samples[i].velocity.norm(), 4.0) << i;  // a lawn mower
  }
  EXPECT_GT(way, 1500.0);  // the logs were published with 1.9 km
  EXPECT_LT(way, 2100.0);
}

TEST(VehicleLogs, KittiPositions) {
  const auto log = io::read_vehicle_log(test_data("plaza/KittiGps_converted.txt"));
  EXPECT_EQ(log.format, "csv");
  EXPECT_EQ(log.samples.size(), 470U);
  EXPECT_THAT(log.convention, HasSubstr("positions from x (east) and y (north)"));
  EXPECT_EQ(log.samples[0].time_ns, 46'534'478'375'790LL);
  EXPECT_NEAR(log.samples[0].position.x(), -6.8269361350059405, kMetre);
  // A car: its heading is the way it drives.
  const auto& s = log.samples[5];
  EXPECT_GT(s.velocity.norm(), 2.0);
  EXPECT_LT(s.velocity.norm(), 30.0);
  EXPECT_NEAR(s.yaw, std::atan2(s.velocity.y(), s.velocity.x()), kAngle);
}

TEST(VehicleLogs, TumTrajectory) {
  const auto log = io::read_vehicle_log(test_data("tum/fr2_desk_groundtruth.txt"));
  EXPECT_EQ(log.format, "tum");
  EXPECT_GT(log.samples.size(), 100U);
  for (const auto& s : log.samples) ASSERT_TRUE(s.position.allFinite() && s.velocity.allFinite());
}

TEST(VehicleLogs, BeaconRangesAreNoMotion) {
  try {
    static_cast<void>(io::read_vehicle_log(test_data("plaza/Plaza1_TD_head.txt")));
    ADD_FAILURE();
  } catch (const base::Error& e) {
    EXPECT_THAT(e.what(), HasSubstr("ranges to beacons"));
    EXPECT_EQ(e.code(), base::ErrorCode::invalid_input);
  }
}

TEST_F(VehicleLogFile, PlazaTurnsAndDrives) {
  const double quarter = std::numbers::pi / 2;
  const auto log = read("0 0 0\n1 2 0\n2 0 " + std::to_string(quarter) + "\n3 3 0\n");
  ASSERT_EQ(log.samples.size(), 4U);
  constexpr double kPrinted = 1e-5;  // six decimals of a quarter turn, 3 m
  EXPECT_LT((log.samples[3].position - geometry::Vec2(2, 3)).norm(), kPrinted);
  EXPECT_NEAR(log.samples[3].yaw, quarter, kPrinted);
}

TEST_F(VehicleLogFile, NamesUnitsAndSeparators) {
  const auto a = read("t;East;North;yaw_deg\n0.5;1;2;90\n1.5;3;2;90\n");
  EXPECT_EQ(a.samples[0].time_ns, 500'000'000);
  EXPECT_NEAR(a.samples[0].yaw, std::numbers::pi / 2, kAngle);
  EXPECT_NEAR(a.samples[0].velocity.x(), 2.0, kMetre);
  const auto b = read("timestamp_us\tx\ty\tvx\tvy\theading\n1000000\t1\t2\t0.5\t0\t90\n");
  EXPECT_EQ(b.samples[0].time_ns, 1'000'000'000);
  EXPECT_NEAR(b.samples[0].yaw, 0.0, kAngle);
  EXPECT_NEAR(b.samples[0].velocity.x(), 0.5, kMetre);
  const auto d = read("%time,field.pose.pose.position.x,field.pose.pose.position.y\n1500000000,1,2\n");
  EXPECT_EQ(d.samples[0].time_ns, 1'500'000'000);
  const auto e = read("Time [s],X [m],Y [m],Vx (m/s),Vy (m/s)\n1,1,2,0.25,0\n");
  EXPECT_NEAR(e.samples[0].velocity.x(), 0.25, kMetre);
  const auto c = read("# a comment\ntime,x,y\n1700000000.123456789,1,2\n");
  EXPECT_EQ(c.samples[0].time_ns, 1'700'000'000'123'456'789LL);
}

TEST_F(VehicleLogFile, LatitudeAndLongitude) {
  const auto log = read("time_s,lat,lon\n0,46.84,-91.99\n10,46.8401,-91.99\n");
  ASSERT_TRUE(log.origin);
  EXPECT_EQ(log.origin->latitude_deg, 46.84);
  constexpr double kArc_m = 0.05;  // 1e-4 deg of the meridian at this latitude: 11.116 m
  EXPECT_NEAR(log.samples[1].position.y(), 11.116, kArc_m);
  EXPECT_NEAR(log.samples[1].position.x(), 0.0, kArc_m);
  EXPECT_NEAR(log.samples[1].yaw, std::numbers::pi / 2, 1e-3);
}

TEST_F(VehicleLogFile, AStandingVehicleKeepsItsHeading) {
  const auto log = read("time_s,x,y\n0,0,0\n1,0,0\n2,0,1\n3,0,2\n4,0,2\n5,0,2\n");
  for (const auto& s : log.samples) EXPECT_NEAR(s.yaw, std::numbers::pi / 2, kAngle);
}

TEST_F(VehicleLogFile, RowsThatCannotBeUsedHaveReasons) {
  const auto log = read("time_s,x,y\n0,0,0\n1,nan,0\n1,1,0\n0.5,2,0\n1,3,0\n2,inf,0\n3,4,0\n");
  EXPECT_EQ(log.samples.size(), 3U);
  ASSERT_EQ(log.rejects.size(), 4U);
  EXPECT_EQ(log.rejects[0].reason, "not_finite");
  EXPECT_EQ(log.rejects[0].record, "line 3");
  EXPECT_EQ(log.rejects[1].reason, "time_not_ascending");
  EXPECT_EQ(log.rejects[3].reason, "not_finite");
}

TEST_F(VehicleLogFile, Refusals) {
  EXPECT_THAT(refusal(""), HasSubstr("no row"));
  EXPECT_THAT(refusal("time_s,x\n0,1\n"), HasSubstr("no positions"));
  EXPECT_THAT(refusal("x,y\n0,1\n"), HasSubstr("no times"));
  EXPECT_THAT(refusal("time_s,x,y\n0,east,1\n"), HasSubstr("not a number"));
  EXPECT_THAT(refusal("time_s,x,y\n0,nan,1\n"), HasSubstr("no row of the log can be used"));
  EXPECT_THAT(refusal("1 2 3 4 5\n"), HasSubstr("not a motion log"));
  EXPECT_THAT(refusal("0 0 0\n1 2\n"), HasSubstr("wrong number of columns"));
  EXPECT_THAT(refusal("time_s,x,y\n0,0,0\n", "rosbag"), HasSubstr("unknown format"));
}

}  // namespace
