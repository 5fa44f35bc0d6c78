#include "pipeline/terrain_stage.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.hpp"
#include "base/random.hpp"
#include "geodesy/local_frame.hpp"
#include "io/cloud.hpp"
#include "io/ply.hpp"
#include "io/raster.hpp"
#include "pipeline/audited_surface.hpp"
#include "support/data.hpp"
#include "support/small_survey.hpp"

namespace cairn::pipeline {
namespace {

using geometry::Vec3;

class TerrainStage : public ::testing::Test {
 protected:
  testing::TempFolder folder_;
  base::RunContext ctx_;
  void SetUp() override {
    testing::write_small_survey(folder_ / "survey", 3, "cloud.ply");
    std::filesystem::create_directories(folder_ / "out");
    geometry::PointCloud cloud;
    base::Random random(2, "cloud", 0);
    for (int i = 0; i < 20000; ++i) {
      const double e = random.uniform(0, 20), n = random.uniform(0, 20);
      if (std::max(std::abs(e - 5.0), std::abs(n - 5.0)) < 0.6) continue;  // a hole that is interpolated
      cloud.positions.emplace_back(e, n, testing::small_survey_up(e, n));
    }
    io::write_cloud(folder_ / "survey/cloud.ply", cloud);
  }
};

TEST_F(TerrainStage, RasterAndMeshAgree) {
  const Outcome outcome = terrain_stage({folder_ / "survey"}, folder_ / "out", {}, ctx_);
  EXPECT_GT(outcome.summary.at("cells_interpolated").as_integer(), 8);
  EXPECT_EQ(outcome.summary.at("height_type").as_string(), "ellipsoidal");
  const io::Raster raster = io::read_raster(folder_ / "out/surface.tif");
  ASSERT_EQ(raster.bands.size(), 4U);
  EXPECT_EQ(raster.bands[0].name, "surface");
  EXPECT_EQ(raster.bands[2].name, "observed");
  const auto& surface = std::get<geometry::Grid<float>>(raster.bands[0].values);
  // Heights in the file stand in the survey's datum, not in local up.
  const auto cell = *surface.geometry.cell_at({12.1, 7.3});
  constexpr double kWithinCell = 0.02;  // m, slope times half a cell
  EXPECT_NEAR(static_cast<double>(surface.at(cell.first, cell.second)), 158.0 + testing::small_survey_up(12.1, 7.3),
              kWithinCell);
  const auto& observed = std::get<geometry::Grid<float>>(raster.bands[2].values);
  const auto hole = *surface.geometry.cell_at({5.0, 5.0});
  EXPECT_EQ(observed.at(hole.first, hole.second), 0.0F);
  EXPECT_TRUE(std::isfinite(surface.at(hole.first, hole.second)));

  // What coverage makes of the raster is the mesh of the file.
  const geodesy::LocalFrame frame(testing::kSmallSurveyOrigin);
  const AuditedSurface audited = read_audited_surface(folder_ / "out/surface.tif", frame, ctx_);
  const io::MeshData mesh = io::read_ply_mesh(folder_ / "out/surface.ply");
  ASSERT_EQ(audited.mesh.vertices.size(), mesh.mesh.vertices.size());
  ASSERT_EQ(audited.observed.size(), mesh.mesh.triangles.size());
  constexpr double kMillimetre = 1e-3;
  for (std::size_t i = 0; i < mesh.mesh.vertices.size(); ++i)
    ASSERT_LT((audited.mesh.vertices[i] - mesh.mesh.vertices[i]).norm(), kMillimetre);
}

TEST_F(TerrainStage, NeedsACloud) {
  testing::write_small_survey(folder_ / "bare", 2);
  try {
    (void)terrain_stage({folder_ / "bare"}, folder_ / "out", {}, ctx_);
    FAIL();
  } catch (const base::Error& e) {
    EXPECT_EQ(e.code(), base::ErrorCode::not_found);
  }
}

}  // namespace
}  // namespace cairn::pipeline
