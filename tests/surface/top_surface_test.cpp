#include "surface/top_surface.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.hpp"
#include "geometry/mass_properties.hpp"
#include "surface/mesh_checks.hpp"
#include "surface/triangulation.hpp"

namespace cairn::surface {
namespace {

using geometry::Vec2;
using geometry::Vec3;

double flat(const Vec2&) {
  return 10.0;
}

TEST(Delaunay, EmptyCircumcirclesAndFullHull) {
  base::Random random(1, "delaunay", 0);
  std::vector<Vec2> points;
  for (int i = 0; i < 60; ++i) points.emplace_back(random.uniform(), random.uniform());
  const auto triangles = delaunay(points);
  double area = 0.0;
  for (const auto& t : triangles) {
    const Vec2 &a = points[t[0]], &b = points[t[1]], &c = points[t[2]];
    const double twice = (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
    ASSERT_GT(twice, 0.0);  // counter-clockwise
    area += twice / 2;
    // Circumcentre.
    const double d = 2 * twice, b2 = (b - a).squaredNorm(), c2 = (c - a).squaredNorm();
    const Vec2 centre = a + Vec2((c - a).y() * b2 - (b - a).y() * c2, (b - a).x() * c2 - (c - a).x() * b2) / d;
    const double radius = (centre - a).norm();
    for (const auto& p : points) EXPECT_GE((p - centre).norm(), radius - 1e-9);
  }
  EXPECT_NEAR(area, geometry::signed_area(geometry::convex_hull(points)), 1e-12);
  EXPECT_TRUE(delaunay(std::vector<Vec2>{{0, 0}, {1, 1}, {2, 2}}).empty());
}

// A letter L of grid points: the notch is followed, the outline stays simple.
TEST(TrimRim, FollowsANotch) {
  std::vector<Vec2> points;
  for (int i = 0; i <= 20; ++i)
    for (int j = 0; j <= 20; ++j)
      if (i <= 10 || j <= 10) points.emplace_back(0.1 * i, 0.1 * j);
  const auto area_of = [&](const std::vector<geometry::Triangle>& triangles) {
    double area = 0.0;
    for (const auto& t : triangles) area += geometry::signed_area({points[t[0]], points[t[1]], points[t[2]]});
    return area;
  };
  const auto all = delaunay(points);
  EXPECT_NEAR(area_of(all), 3.5, 1e-9);  // with the notch's diagonal half
  EXPECT_NEAR(area_of(trim_rim(points, all, 0.2)), 3.0, 0.011);
  EXPECT_NEAR(area_of(trim_rim(points, all, 10.0)), 3.5, 1e-9);
}

TEST(TopSurface, PyramidFrustumIsExact) {
  // Top square at 11, ground at 10: a unit cube whose volume, skirt and cap are known.
  const std::vector<Vec3> points = {{0, 0, 11}, {1, 0, 11}, {1, 1, 11}, {0, 1, 11}};
  const auto body = close_top_surface(points, flat, 10, 0.001);
  EXPECT_TRUE(geometry::topology(body.mesh).closed());
  EXPECT_EQ(geometry::topology(body.mesh).components, 1U);
  const auto mass = geometry::mass_properties(body.mesh);
  EXPECT_NEAR(mass.volume, 1.0, 1e-12);
  EXPECT_LT((mass.centre_of_mass - Vec3(.5, .5, 10.5)).norm(), 1e-12);
  double seen = 0.0;
  for (std::size_t t = 0; t < body.seen.size(); ++t)
    if (body.seen[t] != 0) seen += body.mesh.area_vector(t).norm();
  EXPECT_NEAR(seen / mass.area, 1.0 / 6.0, 1e-12);
}

TEST(TopSurface, ClosedForRandomPointsWithDuplicatesAndPointsBelowGround) {
  for (std::uint64_t trial = 0; trial < 60; ++trial) {
    base::Random random(9, "top", trial);
    std::vector<Vec3> points;
    const auto count = 4 + random.below(120);
    for (std::uint64_t i = 0; i < count; ++i)
      points.emplace_back(5e5 + random.uniform(-1, 1), 3.8e6 + random.uniform(-1, 1), random.uniform(9.9, 11));
    points.push_back(points[0]);
    points.emplace_back(points[1].x(), points[1].y(), points[1].z() - 0.5);
    const auto body = close_top_surface(points, flat, trial % 2 == 0 ? 0.4 : 100, 0.001);
    ASSERT_FALSE(body.mesh.triangles.empty());
    const auto topology = geometry::topology(body.mesh);
    EXPECT_TRUE(topology.closed()) << trial;
    EXPECT_EQ(topology.components, 1U) << trial;
    EXPECT_EQ(topology.degenerate_triangles, 0U);
    EXPECT_FALSE(self_intersects(body.mesh)) << trial;
    EXPECT_GT(geometry::mass_properties(body.mesh).volume, 0.0);
    EXPECT_EQ(body.seen.size(), body.mesh.triangles.size());
  }
}

TEST(TopSurface, NothingFromALineOrTwoPoints) {
  EXPECT_TRUE(close_top_surface(std::vector<Vec3>{{0, 0, 11}, {1, 0, 11}}, flat, 1, 0.001).mesh.triangles.empty());
  EXPECT_TRUE(
      close_top_surface(std::vector<Vec3>{{0, 0, 11}, {1, 1, 11}, {2, 2, 12}}, flat, 9, 0.001).mesh.triangles.empty());
}

}  // namespace
}  // namespace cairn::surface
