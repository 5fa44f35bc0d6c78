#include "visibility/scene.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/parallel.hpp"
#include "base/random.hpp"
#include "support/brute_force_caster.hpp"
#include "support/meshes.hpp"

namespace cairn::visibility {
namespace {

using geometry::Ray;
using geometry::TriangleMesh;
using geometry::Vec3;

// Single precision about the mesh's centre: 2^-24 of the extent, with a margin for the intersection itself.
constexpr double kDistanceTolerance = 1e-5;  // m, scenes of 10 m
// Closer than this to an edge (barycentric), single and double precision may take either side.
constexpr double kEdgeClearance = 1e-4;

std::vector<Ray> random_rays(std::size_t count, double size, const Vec3& centre, std::uint64_t seed) {
  base::Random random(seed, "rays", 0);
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < count; ++i) {
    Vec3 origin, direction;
    for (int k = 0; k < 3; ++k) {
      origin[k] = random.uniform(-size, size);
      direction[k] = random.normal();
    }
    rays.push_back({centre + origin, direction.normalized()});
  }
  return rays;
}

// Whether the ray passes so near an edge, or two surfaces lie so close, that precision decides.
bool ambiguous(const TriangleMesh& mesh, const Ray& ray) {
  std::vector<double> distances;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& tri = mesh.triangles[t];
    const Vec3 c = mesh.centroid(t);
    TriangleMesh one;
    for (const auto v : tri) one.vertices.push_back(c + (mesh.vertices[v] - c) * (1.0 + 3.0 * kEdgeClearance));
    one.triangles.push_back({0, 1, 2});
    const auto hit = testing::intersect(one, 0, ray.origin, ray.direction);
    if (!hit) continue;
    if (hit->edge_clearance < 2.0 * kEdgeClearance) return true;
    distances.push_back(hit->distance);
  }
  std::sort(distances.begin(), distances.end());
  return distances.size() > 1 && distances[1] - distances[0] < 10.0 * kDistanceTolerance;
}

TEST(Scene, FindsTheSameTriangleAsBruteForce) {
  for (const Vec3& centre : {Vec3(0, 0, 0), Vec3(5000, -3000, 200)}) {
    const TriangleMesh mesh = testing::triangle_soup(300, 10.0, 1.0, centre, 1);
    const Scene scene(mesh);
    const auto rays = random_rays(2000, 7.0, centre, 2);
    const auto hits = scene.cast(rays);
    std::size_t compared = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const auto expected = testing::first_hit(mesh, rays[i].origin, rays[i].direction);
      const bool same = hits[i].hit() == expected.has_value() &&
                        (!expected || (hits[i].triangle == expected->triangle &&
                                       std::abs(hits[i].distance - expected->distance) < kDistanceTolerance * 10));
      if (!same) {
        EXPECT_TRUE(ambiguous(mesh, rays[i])) << "ray " << i;
      }
      if (expected) ++compared;
    }
    EXPECT_GT(compared, 300U);
  }
}

TEST(Scene, BlocksTheSameSegmentsAsBruteForce) {
  const TriangleMesh mesh = testing::triangle_soup(150, 10.0, 1.0, Vec3::Zero(), 3);
  const Scene scene(mesh);
  base::Random random(4, "segments", 0);
  std::vector<Segment> segments;
  for (int i = 0; i < 3000; ++i) {
    Segment s;
    for (int k = 0; k < 3; ++k) {
      s.from[k] = random.uniform(-6, 6);
      s.to[k] = random.uniform(-6, 6);
    }
    segments.push_back(s);
  }
  const auto blocked = scene.blocked(segments);
  std::size_t count = 0;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const Vec3 d = segments[i].to - segments[i].from;
    const bool expected = testing::first_hit(mesh, segments[i].from, d, 1.0 - 1e-4).has_value();
    if ((blocked[i] != 0) != expected) {
      EXPECT_TRUE(ambiguous(mesh, {segments[i].from, d.normalized()})) << "segment " << i;
    }
    count += expected ? 1 : 0;
  }
  EXPECT_GT(count, 500U);
  EXPECT_LT(count, 2500U);
}

TEST(Scene, BatchingChangesNothing) {
  const TriangleMesh mesh =
      testing::joined(testing::triangle_soup(2000, 10.0, 1.0, Vec3::Zero(), 5), testing::sphere(Vec3::Zero(), 3.0, 40));
  for (const Tracing tracing : {Tracing::watertight, Tracing::fast}) {
    const Scene scene(mesh, tracing);
    auto rays = random_rays(5000, 7.0, Vec3::Zero(), 6);
    // Rays at vertices and along edges: ties between neighbours.
    for (std::size_t v = 6000; v < mesh.vertices.size(); v += 3)
      rays.push_back({Vec3(0.1, 0.2, 6.5), (mesh.vertices[v] - Vec3(0.1, 0.2, 6.5)).normalized()});
    std::vector<Segment> segments;
    for (const Ray& ray : rays) segments.push_back({ray.origin, ray.origin + 6.0 * ray.direction});
    const auto hits = scene.cast(rays);
    const auto blocked = scene.blocked(segments);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const auto one = scene.cast(std::span(&rays[i], 1));
      ASSERT_EQ(one[0].triangle, hits[i].triangle) << i;
      ASSERT_EQ(one[0].distance, hits[i].distance) << i;
      ASSERT_EQ(scene.blocked(std::span(&segments[i], 1))[0], blocked[i]) << i;
      std::uint8_t from = 9;
      scene.blocked_from(segments[i].from, std::span(&segments[i].to, 1), std::span(&from, 1));
      ASSERT_EQ(from, blocked[i]) << i;
    }
  }
}

TEST(Scene, ThreadsAndTriangleOrderChangeNothing) {
  const TriangleMesh mesh = testing::sphere(Vec3(1, 2, 3), 3.0, 60);
  auto rays = random_rays(4000, 6.0, Vec3(1, 2, 3), 7);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    rays.push_back({Vec3(9, 2, 3), (mesh.vertices[v] - Vec3(9, 2, 3)).normalized()});
  TriangleMesh reversed = mesh;
  std::reverse(reversed.triangles.begin(), reversed.triangles.end());
  std::vector<Hit> serial, parallel;
  {
    const base::ThreadLimit limit(1);
    serial = Scene(mesh).cast(rays);
  }
  {
    const base::ThreadLimit limit(4);
    const Scene scene(mesh);
    parallel.resize(rays.size());
    base::parallel_for(rays.size(), 100, [&](std::size_t begin, std::size_t end) {
      const auto part = scene.cast(std::span(rays).subspan(begin, end - begin));
      std::copy(part.begin(), part.end(), parallel.begin() + static_cast<std::ptrdiff_t>(begin));
    });
  }
  const auto turned = Scene(reversed).cast(rays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_EQ(serial[i].triangle, parallel[i].triangle);
    ASSERT_EQ(serial[i].distance, parallel[i].distance);
    ASSERT_EQ(serial[i].distance, turned[i].distance);
  }
}

TEST(Scene, SphereIsHitWhereItIs) {
  const Vec3 centre(100, 200, 50);
  const Scene scene(testing::sphere(centre, 2.0, 200));
  std::vector<Ray> rays;
  for (int i = 0; i < 100; ++i) {
    const double offset = -1.9 + 3.8 * i / 99.0;
    rays.push_back({centre + Vec3(offset, 0.05, 10), -Vec3::UnitZ()});
  }
  const auto hits = scene.cast(rays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const double x = rays[i].origin.x() - centre.x(), y = 0.05;
    const double expected = 10.0 - std::sqrt(4.0 - x * x - y * y);
    ASSERT_TRUE(hits[i].hit());
    // The facets lie inside the sphere by up to r (1 - cos(pi/400)) = 6e-5 m, more along a slanted ray.
    EXPECT_NEAR(hits[i].distance, expected, 4e-4);
  }
}

TEST(Scene, BoxWallAndSlabsBlockAsTheyMust) {
  const Scene box(testing::box(Vec3(-1, -1, -1), Vec3(1, 1, 1)));
  const std::vector<Segment> segments = {
      {Vec3(0.1, 0.2, 5), Vec3(0.1, 0.2, 1)},     // to the top face: only itself at the end
      {Vec3(0.1, 0.2, 5), Vec3(0.1, 0.2, -1)},    // to the bottom face, through the top
      {Vec3(0.1, 0.2, 0), Vec3(0.3, -0.1, 0.9)},  // inside
      {Vec3(3, 0.2, 0), Vec3(3, 0.2, 9)},         // beside
      {Vec3(0.1, 0.2, 0), Vec3(0.1, 0.2, 0)},     // of zero length
      {Vec3(0.1, 0.2, 0), Vec3(0.1, 0.2, std::nan(""))},
  };
  const std::vector<std::uint8_t> expected = {0, 1, 0, 0, 0, 1};
  EXPECT_EQ(box.blocked(segments), expected);

  // A slab of half the width above a floor hides exactly the half below it from straight above.
  const TriangleMesh two = testing::joined(testing::slab(-5, -5, 5, 5, 0, 20), testing::slab(0, -5, 5, 5, 2, 7));
  const Scene slabs(two);
  std::vector<Segment> down;
  for (std::size_t t = 0; t < 800; ++t) down.push_back({two.centroid(t) + Vec3(0, 0, 10), two.centroid(t)});
  const auto hidden = slabs.blocked(down);
  for (std::size_t t = 0; t < 800; ++t) EXPECT_EQ(hidden[t] != 0, two.centroid(t).x() > 0.0) << t;
  // The gap at the end is a fraction of the segment: 15 % of 10 m reach below the slab 2 m above the floor not,
  // 25 % do.
  EXPECT_EQ(slabs.blocked(std::vector<Segment>{{Vec3(3, 0.1, 10), Vec3(3, 0.1, 0)}}, 0.15)[0], 1);
  EXPECT_EQ(slabs.blocked(std::vector<Segment>{{Vec3(3, 0.1, 10), Vec3(3, 0.1, 0)}}, 0.25)[0], 0);
}

TEST(Scene, MaxDistanceEndsTheRay) {
  const Scene scene(testing::slab(-1, -1, 1, 1, 0, 1));
  const std::vector<Ray> rays = {{Vec3(0.2, 0.1, 5), -Vec3::UnitZ()}};
  EXPECT_TRUE(scene.cast(rays, 5.01)[0].hit());
  EXPECT_FALSE(scene.cast(rays, 4.99)[0].hit());
}

TEST(Scene, LeavesOutWhatIsNoTriangle) {
  TriangleMesh mesh = testing::slab(-1, -1, 1, 1, 0, 1);  // 4 vertices, 2 triangles
  mesh.vertices.emplace_back(std::nan(""), 0, 0);
  mesh.vertices.emplace_back(1e30, 0, 0);
  mesh.vertices.emplace_back(std::numeric_limits<double>::infinity(), 0, 0);
  const auto good = mesh.triangles;
  mesh.triangles = {{0, 0, 1}, {0, 1, 4}, {0, 1, 5}, {0, 6, 2}, {0, 1, 99}};
  mesh.triangles.insert(mesh.triangles.end(), good.begin(), good.end());
  const Scene scene(mesh);
  EXPECT_EQ(scene.skipped_triangles(), 5U);
  const std::vector<Ray> rays = {{Vec3(-0.5, -0.5, 3), -Vec3::UnitZ()}, {Vec3(0.5, 0.5, 3), -Vec3::UnitZ()}};
  const auto hits = scene.cast(rays);
  EXPECT_EQ(hits[0].triangle, 5U);
  EXPECT_EQ(hits[1].triangle, 6U);
}

TEST(Scene, EmptyMeshBlocksNothing) {
  const Scene scene{TriangleMesh{}};
  EXPECT_EQ(scene.blocked(std::vector<Segment>{{Vec3(0, 0, 1), Vec3(0, 0, 0)}})[0], 0);
  EXPECT_FALSE(scene.cast(std::vector<Ray>{{Vec3(0, 0, 1), -Vec3::UnitZ()}})[0].hit());
}

}  // namespace
}  // namespace cairn::visibility
