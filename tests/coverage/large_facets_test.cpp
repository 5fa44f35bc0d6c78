#include "coverage/large_facets.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/random.hpp"
#include "support/meshes.hpp"

namespace cairn::coverage {
namespace {

using geometry::TriangleMesh;
using geometry::Vec3;

constexpr double kArea = 1e-9;  // relative

double area_of(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) sum += mesh.area_vector(f).norm();
  return sum;
}

double longest_edge(const TriangleMesh& mesh) {
  double longest = 0.0;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      longest = std::max(longest, (mesh.vertices[t[k]] - mesh.vertices[t[(k + 1) % 3]]).norm());
  return longest;
}

TEST(LargeFacets, AreCutWithoutGapsAndKeepTheirArea) {
  const TriangleMesh mesh = testing::joined(testing::sphere(Vec3(0, 0, 5), 3.0, 6), testing::box({4, 0, 0}, {5, 9, 1}));
  const CutMesh cut = cut_large_facets(mesh, 0.7, 1'000'000);
  EXPECT_LE(longest_edge(cut.mesh), 0.7);
  EXPECT_EQ(cut.edge_m, 0.7);
  EXPECT_NEAR(area_of(cut.mesh), area_of(mesh), kArea * area_of(mesh));
  // Closed bodies stay closed: neighbours agree on where their edge is cut.
  EXPECT_TRUE(geometry::topology(mesh).closed());
  EXPECT_TRUE(geometry::topology(cut.mesh).closed());
  std::vector<double> of_parent(mesh.triangles.size(), 0.0);
  for (std::size_t f = 0; f < cut.mesh.triangles.size(); ++f) {
    of_parent[cut.parent[f]] += cut.mesh.area_vector(f).norm();
    EXPECT_GT(cut.mesh.area_vector(f).dot(mesh.area_vector(cut.parent[f])), 0.0);
  }
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    EXPECT_NEAR(of_parent[f], mesh.area_vector(f).norm(), kArea * of_parent[f]);
}

TEST(LargeFacets, SmallOnesStayAsTheyAre) {
  const TriangleMesh mesh = testing::slab(0, 0, 4, 4, 0, 8);
  const CutMesh cut = cut_large_facets(mesh, 1.0, 1000);
  EXPECT_EQ(cut.mesh.triangles, mesh.triangles);
  EXPECT_EQ(cut.whole, mesh.triangles.size());
  EXPECT_EQ(cut.mesh.vertices.size(), mesh.vertices.size());
}

TEST(LargeFacets, HugeOnesAreCutNoFinerThanTheLimit) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {5e6, 0, 0}, {0, 5e6, 0}};
  mesh.triangles = {{0, 1, 2}};
  const CutMesh cut = cut_large_facets(mesh, 1.0, 20000);
  EXPECT_LE(cut.mesh.triangles.size(), 20000U);
  EXPECT_GT(cut.mesh.triangles.size(), 1000U);
  EXPECT_LE(longest_edge(cut.mesh), cut.edge_m);
  EXPECT_GT(cut.edge_m, 1.0);
}

TEST(LargeFacets, DegenerateOnesAreLeftAlone) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {50, 0, 0}, {100, 0, 0}, {0, std::nan(""), 0}, {1e9, 0, 0}, {0, 50, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 1, 3}, {0, 4, 5}, {0, 1, 99}, {0, 0, 5}};
  const CutMesh cut = cut_large_facets(mesh, 1.0, 1000);
  EXPECT_EQ(cut.mesh.triangles, mesh.triangles);
}

TEST(LargeFacets, OrderChangesNoPiece) {
  TriangleMesh mesh = testing::triangle_soup(30, 5.0, 3.0, Vec3::Zero(), 4);
  const auto centroids = [](const CutMesh& cut) {
    std::vector<std::array<double, 3>> points;
    for (std::size_t f = 0; f < cut.mesh.triangles.size(); ++f) {
      const Vec3 c = cut.mesh.centroid(f);
      points.push_back({c.x(), c.y(), c.z()});
    }
    std::sort(points.begin(), points.end());
    return points;
  };
  const auto before = centroids(cut_large_facets(mesh, 0.5, 100000));
  std::reverse(mesh.triangles.begin(), mesh.triangles.end());
  EXPECT_EQ(centroids(cut_large_facets(mesh, 0.5, 100000)), before);
}

}  // namespace
}  // namespace cairn::coverage
