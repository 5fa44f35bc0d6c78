#include "surface/mesh_checks.hpp"

#include <gtest/gtest.h>

#include "base/random.hpp"
#include "geometry/mass_properties.hpp"
#include "support/bodies.hpp"

namespace cairn::surface {
namespace {

using namespace cairn::testing;

TEST(ConvexHull3d, BoxesAndRandomPoints) {
  const auto l_shape = prism({{1, 1}, {1, 2}, {0, 2}, {0, 0}, {2, 0}, {2, 1}}, 2);
  const auto hull = convex_hull(l_shape.vertices);
  EXPECT_TRUE(geometry::topology(hull).closed());
  EXPECT_NEAR(geometry::mass_properties(hull).volume, 7.0, 1e-12);  // 4 - the cut-off half square, times 2
  base::Random random(4, "hull", 0);
  std::vector<Vec3> points;
  for (int i = 0; i < 200; ++i)
    points.emplace_back(5e5 + random.uniform(-1, 1), 3.8e6 + random.uniform(-1, 1), random.uniform(-1, 1));
  const auto around = convex_hull(points);
  for (std::size_t t = 0; t < around.triangles.size(); ++t) {
    const Vec3 outward = around.area_vector(t).normalized();
    for (const auto& p : points) EXPECT_LE(outward.dot(p - around.vertices[around.triangles[t][0]]), 1e-8);
  }
}

TEST(ConvexHull3d, NothingFromAPlane) {
  EXPECT_TRUE(
      convex_hull(std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {.5, .5, 0}}).triangles.empty());
  EXPECT_TRUE(convex_hull(std::vector<Vec3>{{0, 0, 0}}).triangles.empty());
}

TEST(SelfIntersections, FoundAndNotInvented) {
  auto mesh = block(1, 1, 3);
  EXPECT_FALSE(self_intersects(mesh));
  EXPECT_FALSE(self_intersects(truncated_ellipsoid(1, .8, 1.2, .9, 24)));
  // Two blocks through one another.
  const auto other = moved(block(1, 1, 3), {0.4, 0.3, 0.2});
  for (const auto& t : other.triangles) mesh.triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  EXPECT_TRUE(self_intersects(mesh));
  auto poked = truncated_ellipsoid(1, .8, 1.2, .9, 24);
  poked.vertices[100] = -1.5 * poked.vertices[100];
  EXPECT_TRUE(self_intersects(poked));
}

}  // namespace
}  // namespace cairn::surface
