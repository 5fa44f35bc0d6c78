#include "io/range_scans.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using ::testing::HasSubstr;
constexpr double kAngle = 1e-12;  // rad: degrees in the file

TEST(RangeScans, ReadBackToTheSameBits) {
  const testing::TempFolder folder;
  survey::RangeScan scan;
  scan.time_ns = 1'700'000'000'123'456'789;
  scan.time_increment_ns = 17361;
  scan.angle_min = -2.35619;
  scan.angle_increment = 0.0043633;
  scan.range_min_m = 0.1;
  scan.range_max_m = 30.0;
  constexpr float kInf = std::numeric_limits<float>::infinity();
  scan.ranges = {1.5F, 0.1F, kInf, -kInf, std::numeric_limits<float>::quiet_NaN(), 29.999998F, 1e-7F};
  survey::RangeScan empty = scan;
  empty.time_ns += 1;
  empty.ranges.clear();
  write_range_scans(folder / "lidar.csv", std::vector{scan, empty});
  const auto read = read_range_scans(folder / "lidar.csv");
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[0].time_ns, scan.time_ns);
  EXPECT_EQ(read[0].time_increment_ns, scan.time_increment_ns);
  EXPECT_NEAR(read[0].angle_min, scan.angle_min, kAngle);
  EXPECT_NEAR(read[0].angle_increment, scan.angle_increment, kAngle);
  EXPECT_EQ(read[0].range_max_m, 30.0);
  ASSERT_EQ(read[0].ranges.size(), scan.ranges.size());
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const bool both_none = std::isnan(scan.ranges[i]) && std::isnan(read[0].ranges[i]);
    EXPECT_TRUE(both_none || read[0].ranges[i] == scan.ranges[i]) << i;
  }
  EXPECT_TRUE(read[1].ranges.empty());
}

TEST(RangeScans, RefusesWhatIsNoScan) {
  const testing::TempFolder folder;
  const std::string header =
      "time_ns,time_increment_ns,angle_min_deg,angle_increment_deg,range_min_m,range_max_m,ranges_m\n";
  const auto message = [&](const std::string& text) -> std::string {
    base::write_file(folder / "lidar.csv", text);
    try {
      (void)read_range_scans(folder / "lidar.csv");
    } catch (const base::Error& error) {
      EXPECT_EQ(error.code(), base::ErrorCode::invalid_input);
      return error.what();
    }
    return "no error";
  };
  EXPECT_THAT(message("time_ns,ranges_m\n1,1\n"), HasSubstr("time_increment_ns"));
  EXPECT_THAT(message(header + "1,0,-90,1,0.1,30,1 2 x\n"), HasSubstr("'x' after 2 ranges"));
  EXPECT_THAT(message(header + "1,0,-90,0,0.1,30,1\n"), HasSubstr("one way"));
  EXPECT_THAT(message(header + "1,0,-90,1,30,0.1,1\n"), HasSubstr("ascend"));
  EXPECT_THAT(message(header + "1,0,-90,1,-1,30,1\n"), HasSubstr("negative"));
  EXPECT_THAT(message(header + "2,0,-90,1,0.1,30,1\n2,0,-90,1,0.1,30,1\n"), HasSubstr("line 3"));
  EXPECT_THAT(message(header + "1,-5,-90,1,0.1,30,1\n"), HasSubstr("time_increment_ns"));
  EXPECT_THAT(message(header + "1,0,nan,1,0.1,30,1\n"), HasSubstr("angle_min_deg"));
  EXPECT_EQ(message(header + "1,0,-90,1,0.1,30,  1   2 \n"), "no error");
  survey::RangeScan scan;
  scan.angle_min = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(write_range_scans(folder / "bad.csv", std::vector{scan}), base::Error);
}

}  // namespace
}  // namespace cairn::io
