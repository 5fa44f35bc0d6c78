#include "simulation/grid_scanner.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace cairn::simulation {
namespace {

TEST(ScanGrid, MeasuresToTheNearBorderOfABlockedCell) {
  geometry::Grid<std::uint8_t> blocked({0.0, 10.0, 0.1, 100, 100}, 0);
  for (std::size_t r = 0; r < 100; ++r) blocked.at(r, 70) = 1;  // a wall from east 7.0 on
  GridScannerOptions options;
  options.sigma_m = 0.0;
  options.dropout_share = 0.0;
  options.step_deg = 15.0;
  options.range_max_m = 3.0;
  base::Random random(1, "scan", 0);
  const auto scan = scan_grid(blocked, {{5.03, 5.02}, 0.0}, 42, options, random);
  ASSERT_EQ(scan.ranges.size(), 19U);
  EXPECT_EQ(scan.time_ns, 42);
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const double angle = scan.angle_min + scan.angle_increment * static_cast<double>(i);
    const double expected = std::cos(angle) > 0.0 ? (7.0 - 5.03) / std::cos(angle) : 1e9;
    constexpr double kFloat_m = 1e-5;  // ranges are single precision, and borders are sums of cells
    if (expected > 3.0) EXPECT_TRUE(std::isinf(scan.ranges[i])) << i;
    else EXPECT_NEAR(scan.ranges[i], expected, kFloat_m) << i;
  }
  // From within reach of the least range.
  const auto near = scan_grid(blocked, {{6.95, 5.02}, 0.0}, 0, options, random);
  EXPECT_EQ(near.ranges[9], -std::numeric_limits<float>::infinity());
}

TEST(ScanGrid, IsNoisyAndDropsRays) {
  geometry::Grid<std::uint8_t> blocked({0.0, 10.0, 0.1, 100, 100}, 0);
  for (std::size_t r = 0; r < 100; ++r) blocked.at(r, 70) = 1;
  GridScannerOptions options;
  options.field_deg = 20.0;
  options.step_deg = 0.05;
  options.dropout_share = 0.1;
  base::Random random(1, "scan", 0);
  const auto scan = scan_grid(blocked, {{5.0, 5.0}, 0.0}, 0, options, random);
  double sum = 0.0, count = 0.0, dropped = 0.0;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    if (std::isnan(scan.ranges[i])) {
      ++dropped;
      continue;
    }
    const double angle = scan.angle_min + scan.angle_increment * static_cast<double>(i);
    sum += std::pow(static_cast<double>(scan.ranges[i]) - 2.0 / std::cos(angle), 2);
    ++count;
  }
  EXPECT_NEAR(std::sqrt(sum / count), 0.02, 0.003);  // 5 sigma of 360 draws
  EXPECT_NEAR(dropped / static_cast<double>(scan.ranges.size()), 0.1, 0.07);
}

}  // namespace
}  // namespace cairn::simulation
