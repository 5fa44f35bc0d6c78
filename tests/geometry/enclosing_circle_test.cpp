#include "geometry/enclosing_circle.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/random.hpp"

namespace {

using cairn::geometry::Circle;
using cairn::geometry::smallest_enclosing_circle;
using cairn::geometry::Vec2;

constexpr double kRounding = 1e-9;  // m: of circles a few metres wide

TEST(EnclosingCircle, OfNoOneAndTwoPoints) {
  EXPECT_EQ(smallest_enclosing_circle({}).radius, 0.0);
  const Circle one = smallest_enclosing_circle({{3, 4}, {3, 4}});
  EXPECT_EQ(one.radius, 0.0);
  EXPECT_EQ(one.centre, Vec2(3, 4));
  const Circle two = smallest_enclosing_circle({{0, 0}, {4, 0}, {2, 0}});
  EXPECT_NEAR(two.radius, 2.0, kRounding);
  EXPECT_NEAR((two.centre - Vec2(2, 0)).norm(), 0.0, kRounding);
}

TEST(EnclosingCircle, OfAnEquilateralTriangleIsItsCircumcircle) {
  const double h = std::sqrt(3.0) / 2.0;
  const Circle c = smallest_enclosing_circle({{0, 0}, {1, 0}, {0.5, h}});
  EXPECT_NEAR(c.radius, 1.0 / std::sqrt(3.0), kRounding);
  EXPECT_NEAR((c.centre - Vec2(0.5, h / 3.0)).norm(), 0.0, kRounding);
}

TEST(EnclosingCircle, OfAnObtuseTriangleSpansItsLongestSide) {
  const Circle c = smallest_enclosing_circle({{-2, 0}, {2, 0}, {0.3, 0.5}});
  EXPECT_NEAR(c.radius, 2.0, kRounding);
}

// Every circle through two or three of the points that holds all of them; the smallest is the answer.
double brute_force_radius(const std::vector<Vec2>& points) {
  double best = 1e300;
  const auto consider = [&](const Vec2& centre) {
    double radius = 0.0;
    for (const Vec2& p : points) radius = std::max(radius, (p - centre).norm());
    best = std::min(best, radius);
  };
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      consider(0.5 * (points[i] + points[j]));
      for (std::size_t k = j + 1; k < points.size(); ++k) {
        const Vec2 b = points[j] - points[i], c = points[k] - points[i];
        const double d = 2.0 * (b.x() * c.y() - b.y() * c.x());
        if (std::abs(d) < 1e-12) continue;
        consider(points[i] + Vec2(c.y() * b.squaredNorm() - b.y() * c.squaredNorm(),
                                  b.x() * c.squaredNorm() - c.x() * b.squaredNorm()) /
                                 d);
      }
    }
  return best;
}

TEST(EnclosingCircle, EqualsBruteForceOnRandomPoints) {
  for (std::uint64_t trial = 0; trial < 200; ++trial) {
    cairn::base::Random random(1, "enclosing circle", trial);
    std::vector<Vec2> points;
    for (std::uint64_t i = 0; i < 3 + trial % 12; ++i) {
      const double x = random.uniform(-5, 5), y = trial % 3 == 0 ? 0.5 * x : random.uniform(-5, 5);
      points.emplace_back(x, y);
    }
    const Circle c = smallest_enclosing_circle(points);
    EXPECT_NEAR(c.radius, brute_force_radius(points), kRounding) << trial;
    for (const Vec2& p : points) EXPECT_LE((p - c.centre).norm(), c.radius + kRounding);
  }
}

}  // namespace
