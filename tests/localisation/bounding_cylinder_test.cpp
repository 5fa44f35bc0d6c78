#include "localisation/bounding_cylinder.hpp"

#include <gtest/gtest.h>

#include "localisation/normal_draws.hpp"

namespace cairn::localisation {
namespace {

TEST(BoundingCylinder, IsH1WhereThePointsAreCompact) {
  // Four points: 3 sigma reaches beyond all of them, so H1 decides.
  Points points(4, 3);
  points << 1, 0, 0, -1, 0, 2, 0, 1, 1, 0, -1, 1;
  const auto c = bounding_cylinder(points);
  EXPECT_NEAR(c.radius, 1.0, 1e-12);
  EXPECT_NEAR(c.bottom, 0.0, 1e-12);
  EXPECT_NEAR(c.top, 2.0, 1e-12);
  EXPECT_NEAR(c.axis.norm(), 0.0, 1e-12);
}

TEST(BoundingCylinder, IsH2WhereThereAreStragglers) {
  Points points(10001, 3);
  base::Random random(12, "test", 0);
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    fill_normal({points.col(axis).data(), static_cast<std::size_t>(points.rows())}, random);
  points.col(1) *= 0.5;
  points.col(2) *= 0.25;
  points.row(10000) << 40.0, 0.0, 30.0;
  const Gaussian g = fit_gaussian(points);
  const auto c = bounding_cylinder(points);
  EXPECT_NEAR(c.radius, 3.0 * std::sqrt(g.covariance(0, 0)), 1e-12);  // the larger of the two sigmas
  EXPECT_NEAR(c.top, g.mean.z() + 3.0 * std::sqrt(g.covariance(2, 2)), 1e-12);
  // A23's bottom is the higher of the two: the lowest point here is above mean - 3 sigma.
  EXPECT_NEAR(c.bottom, std::max(points.col(2).minCoeff(), g.mean.z() - 3.0 * std::sqrt(g.covariance(2, 2))), 1e-12);
  EXPECT_NEAR((c.axis - g.mean.head<2>()).norm(), 0.0, 1e-12);
}

TEST(BoundingCylinder, OfOnePointHasNoExtent) {
  Points points(1, 3);
  points << 3, 4, 5;
  const auto c = bounding_cylinder(points);
  EXPECT_EQ(c.radius, 0.0);
  EXPECT_EQ(c.height(), 0.0);
}

}  // namespace
}  // namespace cairn::localisation
