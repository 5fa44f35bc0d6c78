#include "segmentation/local_ground.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "base/random.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Vec2;
using geometry::Vec3;

constexpr double kNoise = 0.01;  // m
const Vec2 kCentre(500010.0, 3800020.0);

// An annulus of 600 ground points on a slope, a share of which is hidden under a bush.
std::vector<Vec3> annulus(double bush_share) {
  base::Random random(11, "ground", 0);
  std::vector<Vec3> points;
  for (int i = 0; i < 600; ++i) {
    const double a = random.uniform(0, 6.28318), r = random.uniform(1.0, 2.0);
    const Vec2 d(r * std::cos(a), r * std::sin(a));
    double z = 1500 + 0.2 * d.x() - 0.1 * d.y() + kNoise * random.normal();
    if (a < 6.28318 * bush_share && random.uniform() < 0.8) z += random.uniform(0.2, 0.8);
    points.emplace_back(kCentre.x() + d.x(), kCentre.y() + d.y(), z);
  }
  return points;
}

TEST(LocalGround, PlaneUnderBushes) {
  for (const double share : {0.0, 0.2, 0.35}) {
    const auto ground = fit_ground(annulus(share), kCentre);
    ASSERT_TRUE(ground) << share;
    // 600 points of 1 cm noise give well under a millimetre; outliers pull by a fraction of the noise.
    const double tolerance = share > 0.0 ? 0.01 : 0.002;
    EXPECT_NEAR(ground->up_at_centre, 1500.0, tolerance) << share;
    EXPECT_NEAR(ground->slope.x(), 0.2, tolerance) << share;
    EXPECT_NEAR(ground->slope.y(), -0.1, tolerance) << share;
    EXPECT_EQ(ground->sectors, 8U);
    EXPECT_NEAR(ground->noise, kNoise, share > 0.0 ? 0.015 : 0.002) << share;
    EXPECT_NEAR(ground->height_above({kCentre.x() + 1, kCentre.y(), 1501.2}), 1.0, 2 * tolerance);
  }
}

TEST(LocalGround, RefusesPointsOnALine) {
  std::vector<Vec3> line;
  for (int i = 0; i < 50; ++i) line.emplace_back(i, 2 * i, 0);
  EXPECT_FALSE(fit_ground(line, {0, 0}));
  EXPECT_FALSE(fit_ground(std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}}, {0, 0}));
}

}  // namespace
}  // namespace cairn::segmentation
