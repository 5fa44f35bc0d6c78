#include "coverage/sight_lines.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/random.hpp"

namespace cairn::coverage {
namespace {

constexpr double kTolerance = 1e-6;  // rad, single precision of the components

double by_pairs(const SightLines& s) {
  double widest = 0.0;
  const auto at = [&s](std::size_t i) {
    return geometry::Vec3(static_cast<double>(s.x[i]), static_cast<double>(s.y[i]), static_cast<double>(s.z[i]));
  };
  for (std::size_t i = 0; i < s.size(); ++i)
    for (std::size_t j = i + 1; j < s.size(); ++j)
      widest = std::max(widest, std::atan2(at(i).cross(at(j)).norm(), at(i).dot(at(j))));
  return widest;
}

TEST(LargestAngle, EqualsAllPairs) {
  base::Random random(3, "angles", 0);
  for (int trial = 0; trial < 400; ++trial) {
    SightLines lines, scratch;
    const std::uint64_t n = 2 + random.below(60);
    const double spread = std::pow(10.0, random.uniform(-4.0, 0.5));
    for (std::uint64_t i = 0; i < n; ++i)
      lines.add(geometry::Vec3(spread * random.normal(), spread * random.normal(), 1.0).normalized());
    ASSERT_NEAR(largest_angle(lines.x, lines.y, lines.z, scratch), by_pairs(lines), kTolerance) << trial;
  }
}

TEST(LargestAngle, KnowsItsLimits) {
  SightLines lines, scratch;
  lines.add(geometry::Vec3(0, 0, 1));
  lines.add(geometry::Vec3(0, 0, 1));
  EXPECT_EQ(largest_angle(lines.x, lines.y, lines.z, scratch), 0.0);
  lines.add(geometry::Vec3(0, 0, -1));
  EXPECT_NEAR(largest_angle(lines.x, lines.y, lines.z, scratch), 3.14159265358979, kTolerance);
}

}  // namespace
}  // namespace cairn::coverage
