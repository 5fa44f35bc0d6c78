#include "geometry/grid_mesh.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace cairn::geometry {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

TEST(GridMesh, PlaneStaysAPlaneInside) {
  Grid<float> heights(GridGeometry{100.0, 50.0, 0.5, 6, 4}, 0.0F);
  for (std::size_t r = 0; r < 4; ++r)
    for (std::size_t c = 0; c < 6; ++c) {
      const Vec2 p = heights.geometry.centre(r, c);
      heights.at(r, c) = static_cast<float>(0.25 * p.x() - 0.5 * p.y());
    }
  const GridMesh result = grid_mesh(heights);
  ASSERT_EQ(result.mesh.triangles.size(), 2U * 6U * 4U);
  ASSERT_EQ(result.facet_cell.size(), result.mesh.triangles.size());
  EXPECT_EQ(result.mesh.vertices.size(), 7U * 5U);
  double plan = 0.0;
  for (std::size_t t = 0; t < result.mesh.triangles.size(); ++t) {
    const Vec3 a = result.mesh.area_vector(t);
    EXPECT_GT(a.z(), 0.0);
    plan += a.z();
    // The centroid lies in the facet's own cell.
    const auto cell = heights.geometry.cell_at(result.mesh.centroid(t).head<2>());
    ASSERT_TRUE(cell.has_value());
    EXPECT_EQ(cell->first * 6 + cell->second, result.facet_cell[t]);
  }
  EXPECT_NEAR(plan, 6 * 4 * 0.25, 1e-9);
  for (const Vec3& v : result.mesh.vertices) {
    const bool inner = v.x() > 100.1 && v.x() < 102.9 && v.y() < 49.9 && v.y() > 48.1;
    if (inner) {
      EXPECT_NEAR(v.z(), 0.25 * v.x() - 0.5 * v.y(), 1e-5);  // single precision of the cells
    }
  }
  EXPECT_EQ(topology(result.mesh).components, 1U);
  EXPECT_EQ(topology(result.mesh).inconsistent_edges, 0U);
}

TEST(GridMesh, EmptyCellsAreLeftOut) {
  Grid<float> heights(GridGeometry{0.0, 3.0, 1.0, 3, 3}, 1.0F);
  heights.at(1, 1) = kNan;
  const GridMesh ring = grid_mesh(heights);
  EXPECT_EQ(ring.mesh.triangles.size(), 16U);
  for (const auto cell : ring.facet_cell) EXPECT_NE(cell, 4U);
  for (auto& h : heights.values) h = kNan;
  heights.at(0, 2) = 5.0F;
  const GridMesh one = grid_mesh(heights);
  ASSERT_EQ(one.mesh.vertices.size(), 4U);
  EXPECT_EQ(one.mesh.vertices[0], Vec3(2.0, 3.0, 5.0));
  EXPECT_EQ(one.facet_cell, (std::vector<std::uint32_t>{2, 2}));
  heights.at(0, 2) = kNan;
  EXPECT_TRUE(grid_mesh(heights).mesh.vertices.empty());
  EXPECT_TRUE(grid_mesh({}).mesh.triangles.empty());
}

}  // namespace
}  // namespace cairn::geometry
