#include "coverage/sight_lines.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "base/random.hpp"

namespace cairn::coverage {
namespace {

constexpr double kTolerance = 1e-6;  // rad, single precision of the components

// Angles of all pairs, descending.
std::vector<double> by_pairs(const SightLines& s) {
  std::vector<double> angles;
  const auto at = [&s](std::size_t i) {
    return geometry::Vec3(static_cast<double>(s.x[i]), static_cast<double>(s.y[i]), static_cast<double>(s.z[i]));
  };
  for (std::size_t i = 0; i < s.size(); ++i)
    for (std::size_t j = i + 1; j < s.size(); ++j)
      angles.push_back(std::atan2(at(i).cross(at(j)).norm(), at(i).dot(at(j))));
  std::sort(angles.begin(), angles.end(), std::greater<>());
  return angles;
}

TEST(WidestAngles, EqualAllPairs) {
  base::Random random(3, "angles", 0);
  for (int trial = 0; trial < 400; ++trial) {
    SightLines lines, scratch;
    const std::uint64_t n = 3 + random.below(60);
    const double spread = std::pow(10.0, random.uniform(-4.0, 0.5));
    for (std::uint64_t i = 0; i < n; ++i)
      lines.add(geometry::Vec3(spread * random.normal(), spread * random.normal(), 1.0).normalized());
    const std::vector<double> expected = by_pairs(lines);
    const WidestAngles widest = widest_angles(lines.x, lines.y, lines.z, scratch);
    ASSERT_NEAR(widest.first, expected[0], kTolerance) << trial;
    ASSERT_NEAR(widest.second, expected[1], kTolerance) << trial;
  }
}

TEST(WidestAngles, KnowTheirLimits) {
  SightLines lines, scratch;
  lines.add(geometry::Vec3(0, 0, 1));
  lines.add(geometry::Vec3(0, 0, 1));
  WidestAngles widest = widest_angles(lines.x, lines.y, lines.z, scratch);
  EXPECT_EQ(widest.first, 0.0);
  EXPECT_TRUE(std::isnan(widest.second));
  lines.add(geometry::Vec3(0, 0, 1));
  widest = widest_angles(lines.x, lines.y, lines.z, scratch);
  EXPECT_EQ(widest.first, 0.0);
  EXPECT_EQ(widest.second, 0.0);
  lines.add(geometry::Vec3(0, 0, -1));
  widest = widest_angles(lines.x, lines.y, lines.z, scratch);
  EXPECT_NEAR(widest.first, 3.14159265358979, kTolerance);
  EXPECT_NEAR(widest.second, 3.14159265358979, kTolerance);
}

}  // namespace
}  // namespace cairn::coverage
