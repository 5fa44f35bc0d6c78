#include "segmentation/terrain.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/random.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Vec2;
using geometry::Vec3;

double bare(double x, double y) {
  return 0.1 * x + 0.3 * std::sin(0.3 * y);
}

// Sloping ground of 30 x 30 m, a boulder (half ball, radius 1 m) at (10, 10), a car of 4 x 2 x 1.5 m at (20, 20), a gap
// of 1.5 m about (5, 25) and one of 6 m about (24, 6).
std::vector<Vec3> scene() {
  base::Random random(8, "scene", 0);
  std::vector<Vec3> points;
  for (int i = 0; i < 120000; ++i) {
    const double x = random.uniform(0, 30), y = random.uniform(0, 30);
    if (std::max(std::abs(x - 5), std::abs(y - 25)) < 0.75 || std::max(std::abs(x - 24), std::abs(y - 6)) < 3.0)
      continue;
    double z = bare(x, y);
    const double r2 = (x - 10) * (x - 10) + (y - 10) * (y - 10);
    if (r2 < 1.0) z = bare(10, 10) + std::sqrt(1.0 - r2);
    if (std::abs(x - 20) < 2 && std::abs(y - 20) < 1) z = bare(20, 20) + 1.5;
    points.emplace_back(x, y, z);
  }
  return points;
}

TerrainModel model(const std::vector<Vec3>& points, const TerrainOptions& options = {}) {
  base::RunContext ctx;
  return model_terrain(points, options, ctx);
}

TEST(Terrain, SurfaceGroundAndHoles) {
  const TerrainModel m = model(scene());
  const auto at = [&m](const auto& grid, double x, double y) {
    const auto cell = m.surface.geometry.cell_at(Vec2(x, y));
    return grid.at(cell->first, cell->second);
  };
  EXPECT_NEAR(at(m.surface, 10.0, 10.0), bare(10, 10) + 1.0, 0.05);
  EXPECT_NEAR(at(m.ground, 10.0, 10.0), bare(10, 10), 0.15);
  EXPECT_NEAR(at(m.surface, 20.0, 20.0), bare(20, 20) + 1.5, 0.01);
  EXPECT_NEAR(at(m.ground, 20.0, 20.0), bare(20, 20), 0.15);
  EXPECT_EQ(at(m.observed, 10.0, 10.0), 1);
  // The narrow hole is interpolated and marked, the wide one stays empty.
  EXPECT_EQ(at(m.observed, 5.0, 25.0), 0);
  EXPECT_NEAR(at(m.surface, 5.0, 25.0), bare(5, 25), 0.06);
  EXPECT_TRUE(std::isnan(at(m.surface, 24.0, 6.0)));
  EXPECT_TRUE(std::isnan(at(m.ground, 24.0, 6.0)));
  EXPECT_EQ(at(m.points, 24.0, 6.0), 0U);
  EXPECT_GT(m.interpolated, 10U);

  std::size_t cells = 0, off = 0;
  for (std::size_t r = 0; r < m.ground.geometry.rows; ++r)
    for (std::size_t c = 0; c < m.ground.geometry.columns; ++c) {
      const float ground = m.ground.at(r, c);
      if (!std::isfinite(ground)) continue;
      ASSERT_LE(ground, m.surface.at(r, c));
      const Vec2 p = m.ground.geometry.centre(r, c);
      ++cells;
      off += std::abs(static_cast<double>(ground) - bare(p.x(), p.y())) > 0.2 ? 1U : 0U;
    }
  EXPECT_GT(cells, 10000U);
  EXPECT_LT(off, cells / 100);
}

TEST(Terrain, LonePointsAreNoSurface) {
  auto points = scene();
  points.emplace_back(15.1, 15.1, 40.0);   // a bird
  points.emplace_back(12.1, 22.1, -30.0);  // a reflection
  const TerrainModel m = model(points);
  const auto cell = *m.surface.geometry.cell_at(Vec2(15.1, 15.1));
  EXPECT_NEAR(m.surface.at(cell.first, cell.second), bare(15.1, 15.1), 0.1);
  const auto low = *m.surface.geometry.cell_at(Vec2(12.1, 22.1));
  EXPECT_NEAR(m.ground.at(low.first, low.second), bare(12.1, 22.1), 0.1);
  EXPECT_EQ(m.spikes, 1U);
}

TEST(Terrain, ThreadsChangeNothing) {
  const auto points = scene();
  TerrainModel one, four;
  {
    const base::ThreadLimit limit(1);
    one = model(points);
  }
  {
    const base::ThreadLimit limit(4);
    four = model(points);
  }
  const auto same = [](float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); };
  EXPECT_TRUE(std::equal(one.surface.values.begin(), one.surface.values.end(), four.surface.values.begin(), same));
  EXPECT_TRUE(std::equal(one.ground.values.begin(), one.ground.values.end(), four.ground.values.begin(), same));
}

TEST(Terrain, OnePointIsACell) {
  const TerrainModel m = model({Vec3(3.0, 4.0, 5.0)});
  EXPECT_EQ(m.surface.values.size(), 1U);
  EXPECT_EQ(m.surface.values[0], 5.0F);
  EXPECT_EQ(m.ground.values[0], 5.0F);
  EXPECT_EQ(m.observed.values[0], 1);
}

TEST(Terrain, RefusesWhatHasNoExtent) {
  EXPECT_THROW(model({}), base::Error);
  EXPECT_THROW(model({Vec3(std::nan(""), 0, 0)}), base::Error);
  try {
    model({Vec3(0, 0, 0), Vec3(1e7, 1e7, 0)});
    FAIL();
  } catch (const base::Error& e) {
    EXPECT_EQ(e.code(), base::ErrorCode::failed_precondition);
    EXPECT_NE(e.hint().find("--cell-m"), std::string::npos);
  }
  const TerrainModel m = model({Vec3(0, 0, 1), Vec3(1, 1, std::nan("")), Vec3(1, 1, 2)});
  EXPECT_EQ(m.not_finite, 1U);
}

}  // namespace
}  // namespace cairn::segmentation
