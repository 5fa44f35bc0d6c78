#include "ground/ground_height.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.hpp"

namespace cairn::ground {
namespace {

using geometry::Ray;
using geometry::Vec3;

constexpr double kHit = 1e-8;  // m; the bisection stops at 1e-9

TEST(CastOnGround, MeetsAPlaneExactly) {
  const Ray ray{Vec3(1, 2, 10), Vec3(0.6, 0.0, -0.8)};
  const auto hit = cast_on_ground(ray, {{}, 2.0}, 0.0, 100.0, 0.25);
  ASSERT_TRUE(hit);
  EXPECT_DOUBLE_EQ(hit->range, 10.0);
  EXPECT_FALSE(hit->on_terrain);
  EXPECT_LT((hit->point - Vec3(7, 2, 2)).norm(), kHit);
  EXPECT_FALSE(cast_on_ground(ray, {{}, 2.0}, 0.0, 9.9, 0.25));
  EXPECT_FALSE(cast_on_ground({Vec3(0, 0, 10), Vec3(1, 0, 0)}, {{}, 2.0}, 0.0, 1e9, 0.25));
  EXPECT_FALSE(cast_on_ground({Vec3(0, 0, 1), Vec3(0, 0, -1)}, {{}, 2.0}, 0.0, 100.0, 0.25));
}

// Against a march of millimetres, on waves whose crests hide ground.
TEST(CastOnGround, FindsTheFirstCrossing) {
  const GroundHeight waves = [](double e, double n) {
    return std::optional<double>(2.0 * std::sin(0.4 * e) + 0.5 * std::cos(0.9 * n));
  };
  base::Random random(2, "ground_height", 0);
  for (int i = 0; i < 100; ++i) {
    const double angle = random.uniform(0, 6), sink = random.uniform(0.1, 1.0);
    const Ray ray{Vec3(random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(4, 15)),
                  Vec3(std::cos(angle), std::sin(angle), -sink).normalized()};
    const auto hit = cast_on_ground(ray, {waves, 0.0}, 0.3, 400.0, 0.1);
    ASSERT_TRUE(hit);
    EXPECT_TRUE(hit->on_terrain);
    double r = 0.0;
    for (; r < 400.0; r += 1e-3) {
      const Vec3 p = ray.origin + r * ray.direction;
      if (p.z() <= *waves(p.x(), p.y()) + 0.3) break;
    }
    EXPECT_NEAR(hit->range, r, 1.1e-3);
  }
}

TEST(CastOnGround, FallsBackOnThePlaneBesideTheTerrain) {
  const GroundHeight patch = [](double e, double) { return e < 0.0 ? std::optional<double>(3.0) : std::nullopt; };
  const auto beside = cast_on_ground({Vec3(1, 0, 10), Vec3(0, 0, -1)}, {patch, 1.0}, 0.0, 100.0, 0.25);
  ASSERT_TRUE(beside);
  EXPECT_NEAR(beside->point.z(), 1.0, kHit);
  EXPECT_FALSE(beside->on_terrain);
  const auto on = cast_on_ground({Vec3(-1, 0, 10), Vec3(0, 0, -1)}, {patch, 1.0}, 0.5, 100.0, 0.25);
  ASSERT_TRUE(on);
  EXPECT_NEAR(on->point.z(), 3.5, kHit);
  EXPECT_TRUE(on->on_terrain);
}

}  // namespace
}  // namespace cairn::ground
