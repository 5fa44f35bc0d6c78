#include "evaluation/line_distance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/error.hpp"

namespace cairn::evaluation {
namespace {

using geometry::Vec3;

Polyline circle(double radius, double z, std::size_t sides, double from = 0.0, double to = 1.0) {
  Polyline line;
  line.closed = from == 0.0 && to == 1.0;
  for (std::size_t i = 0; i < sides; ++i) {
    const double t = from + (to - from) * static_cast<double>(i) / static_cast<double>(line.closed ? sides : sides - 1);
    const double a = 2.0 * std::numbers::pi * t;
    line.points.emplace_back(radius * std::cos(a), radius * std::sin(a), z);
  }
  return line;
}

// Polygons of 720 sides differ from circles by 1e-5 of their radius.
constexpr double kSides = 2e-5;  // m

TEST(LineDistance, ConcentricCirclesAreTheirRadiiApart) {
  const auto d = line_distance({circle(1.02, 0.0, 720)}, {circle(1.0, 0.0, 720)});
  EXPECT_NEAR(d.mean, 0.02, kSides);
  EXPECT_NEAR(d.from_true, 0.02, kSides);
  EXPECT_NEAR(d.hausdorff, 0.02, kSides);
  EXPECT_NEAR(line_distance({circle(1.0, 0.03, 720)}, {circle(1.0, 0.0, 720)}).p95, 0.03, kSides);
}

// Half a circle lies on the whole one; the whole one does not lie on the half.
TEST(LineDistance, WhatIsMissingShowsInTheOtherDirection) {
  const auto d = line_distance({circle(1.0, 0.0, 720, 0.0, 0.5)}, {circle(1.0, 0.0, 720)});
  EXPECT_NEAR(d.mean, 0.0, kSides);
  // From a point at angle t past the end the nearest end is a chord 2 sin(t/2) away: mean over 0..pi/2 of both halves.
  const double mean_of_missing = 4.0 * (1.0 - std::cos(std::numbers::pi / 4.0)) * 2.0 / std::numbers::pi;
  EXPECT_NEAR(d.from_true, 0.5 * mean_of_missing, 1e-4);
  EXPECT_NEAR(d.hausdorff, std::sqrt(2.0), 0.01);
}

// A line of unevenly set vertices: the mean is over length, not over vertices.
TEST(LineDistance, DoesNotDependOnTheSpacingOfVertices) {
  Polyline truth{{Vec3(0, 0, 0), Vec3(10, 0, 0)}, false};
  Polyline found{{Vec3(0, 0, 0), Vec3(0.1, 0, 0), Vec3(0.2, 0, 0), Vec3(0.3, 0, 0), Vec3(10, 1, 0)}, false};
  EXPECT_NEAR(line_distance({found}, {truth}).mean, 0.5 * 9.75 / 10.05, 0.005);
}

TEST(LineDistance, SeveralPadsPointsAndNothing) {
  const Polyline one{{Vec3(0, 0, 0)}, true}, other{{Vec3(3, 4, 0)}, true};
  EXPECT_DOUBLE_EQ(line_distance({one}, {other}).hausdorff, 5.0);
  EXPECT_NEAR(line_distance({circle(0.1, 0, 90)}, {circle(0.1, 0, 90), circle(0.1, 1, 90)}).from_true, 0.5, 1e-3);
  EXPECT_EQ(line_distance({}, {one}).samples, 0U);
  EXPECT_THROW((void)line_distance({one}, {other}, 0.0), base::Error);
}

}  // namespace
}  // namespace cairn::evaluation
