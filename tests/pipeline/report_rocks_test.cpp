#include <gtest/gtest.h>

#include "pipeline/report_parts.hpp"

namespace cairn::pipeline {
namespace {

// A prism on an inclined plane: two lids of two triangles, four sides of two.
geometry::TriangleMesh prism(double slope) {
  geometry::TriangleMesh mesh;
  for (const double up : {0.0, 1.0})
    for (const auto& [x, y] : {std::pair{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}})
      mesh.vertices.emplace_back(100.0 + x, -40.0 + y, 7.0 + slope * x + up);
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}};
  for (std::uint32_t i = 0; i < 4; ++i) {
    const std::uint32_t j = (i + 1) % 4;
    mesh.triangles.push_back({i, j, j + 4});
    mesh.triangles.push_back({i, j + 4, i + 4});
  }
  return mesh;
}

double unseen_share(const geometry::TriangleMesh& mesh) {
  double all = 0.0, lid = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    all += mesh.area_vector(t).norm();
    if (t == 2 || t == 3) lid += mesh.area_vector(t).norm();
  }
  return 1.0 - lid / all;
}

TEST(SeenTriangles, OnlyTheUpperLidOfAPrismWasSeen) {
  for (const double slope : {0.0, 0.3}) {
    const auto mesh = prism(slope);
    const std::vector<geometry::Vec3> contact(mesh.vertices.begin(), mesh.vertices.begin() + 4);
    EXPECT_EQ(seen_triangles(mesh, contact, unseen_share(mesh)),
              (std::vector<std::uint8_t>{0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0}));
  }
}

TEST(SeenTriangles, SaysNothingWhereTheShareDoesNotFit) {
  const auto mesh = prism(0.0);
  const std::vector<geometry::Vec3> contact(mesh.vertices.begin(), mesh.vertices.begin() + 4);
  EXPECT_TRUE(seen_triangles(mesh, contact, 0.3).empty());
  EXPECT_TRUE(seen_triangles(mesh, {contact[0], contact[1]}, unseen_share(mesh)).empty());
}

}  // namespace
}  // namespace cairn::pipeline
