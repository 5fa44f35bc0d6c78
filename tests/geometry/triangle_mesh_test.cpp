#include "geometry/triangle_mesh.hpp"

#include <gtest/gtest.h>

namespace cairn::geometry {
namespace {

TriangleMesh tetrahedron() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}, {}};
}

TEST(Topology, ClosedOpenAndTurnedOver) {
  const TriangleMesh closed = tetrahedron();
  EXPECT_TRUE(topology(closed).closed());
  EXPECT_EQ(topology(closed).components, 1U);

  TriangleMesh open = closed;
  open.triangles.pop_back();
  EXPECT_EQ(topology(open).boundary_edges, 3U);

  TriangleMesh mixed = closed;
  std::swap(mixed.triangles[0][1], mixed.triangles[0][2]);
  EXPECT_EQ(topology(mixed).inconsistent_edges, 3U);
  EXPECT_FALSE(topology(mixed).closed());
}

TEST(Topology, CountsShellsAndFins) {
  TriangleMesh two = tetrahedron();
  for (const auto& v : tetrahedron().vertices) two.vertices.push_back(v + Vec3(5, 0, 0));
  for (const auto& t : tetrahedron().triangles) two.triangles.push_back({t[0] + 4, t[1] + 4, t[2] + 4});
  EXPECT_EQ(topology(two).components, 2U);
  EXPECT_TRUE(topology(two).closed());

  TriangleMesh fin = tetrahedron();
  fin.vertices.emplace_back(-1, -1, 0);
  fin.triangles.push_back({0, 1, 4});
  EXPECT_EQ(topology(fin).non_manifold_edges, 1U);
}

TEST(Weld, JoinsEqualVerticesAndDropsDegenerates) {
  TriangleMesh soup;
  const TriangleMesh closed = tetrahedron();
  for (const auto& t : closed.triangles)
    for (const auto v : t) {
      if (soup.vertices.size() % 3 == 0)
        soup.triangles.push_back({static_cast<std::uint32_t>(soup.vertices.size()),
                                  static_cast<std::uint32_t>(soup.vertices.size() + 1),
                                  static_cast<std::uint32_t>(soup.vertices.size() + 2)});
      soup.vertices.push_back(closed.vertices[v]);
    }
  soup.triangles.push_back({0, 0, 1});
  EXPECT_FALSE(topology(soup).closed());
  const TriangleMesh welded = weld(soup);
  EXPECT_EQ(welded.vertices.size(), 4U);
  EXPECT_EQ(welded.triangles.size(), 4U);
  EXPECT_TRUE(topology(welded).closed());
}

TEST(Flipped, TurnsTheAreaVectors) {
  const TriangleMesh mesh = tetrahedron();
  EXPECT_EQ(flipped(mesh).area_vector(0), -mesh.area_vector(0));
}

}  // namespace
}  // namespace cairn::geometry
