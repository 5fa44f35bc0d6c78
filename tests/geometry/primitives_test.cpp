#include "geometry/primitives.hpp"

#include <gtest/gtest.h>

#include "base/random.hpp"

namespace cairn::geometry {
namespace {

TEST(Ring, AreaKeepsItsDigitsAtAUtmOffset) {
  constexpr double kTol = 1e-9;  // one unit in the last place of a northing, times the side
  const Vec2 offset(500000.0, 5188114.0);
  const Ring square{offset, offset + Vec2(1, 0), offset + Vec2(1, 1), offset + Vec2(0, 1)};
  EXPECT_NEAR(signed_area(square), 1.0, kTol);
  EXPECT_NEAR(signed_area({square[3], square[2], square[1], square[0]}), -1.0, kTol);
}

TEST(Ring, ContainsFollowsTheOutline) {
  const Ring notched{{0, 0}, {4, 0}, {4, 4}, {2, 1}, {0, 4}};
  EXPECT_TRUE(contains(notched, {1, 0.5}));
  EXPECT_FALSE(contains(notched, {2, 2}));
  EXPECT_FALSE(contains(notched, {-1, 1}));
  EXPECT_FALSE(contains({}, {0, 0}));
}

TEST(ConvexHull, HoldsEveryPointAndIsCounterClockwise) {
  constexpr double kTol = 1e-12;  // cross products of numbers of order 1
  base::Random random(2, "hull", 0);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<Vec2> points(3 + random.below(60));
    for (auto& p : points)
      p = {random.uniform(), trial % 2 == 0 ? random.uniform() : static_cast<double>(random.below(4))};
    const Ring hull = convex_hull(points);
    if (hull.size() < 3) continue;
    EXPECT_GT(signed_area(hull), 0.0);
    for (std::size_t i = 0; i < hull.size(); ++i) {
      const Vec2& a = hull[i];
      const Vec2 d = hull[(i + 1) % hull.size()] - a;
      for (const auto& p : points) EXPECT_GE(d.x() * (p.y() - a.y()) - d.y() * (p.x() - a.x()), -kTol);
    }
  }
}

TEST(ConvexHull, DegenerateInputs) {
  EXPECT_EQ(convex_hull({}).size(), 0U);
  EXPECT_EQ(convex_hull({{1, 1}, {1, 1}, {1, 1}}).size(), 1U);
  EXPECT_EQ(convex_hull({{0, 0}, {1, 1}, {2, 2}, {3, 3}}).size(), 2U);
  EXPECT_EQ(convex_hull({{0, 0}, {1, 0}, {2, 0}, {2, 2}, {0, 2}}).size(), 4U);
}

TEST(Box3, EmptyUntilExtended) {
  Box3 box;
  EXPECT_TRUE(box.empty());
  EXPECT_EQ(box.size(), Vec3::Zero());
  box.extend({1, 2, 3});
  EXPECT_FALSE(box.empty());
  EXPECT_EQ(box.centre(), Vec3(1, 2, 3));
}

}  // namespace
}  // namespace cairn::geometry
