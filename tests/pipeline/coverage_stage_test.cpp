#include "pipeline/coverage_stage.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "geodesy/local_frame.hpp"
#include "io/gaps_json.hpp"
#include "io/ply.hpp"
#include "io/raster.hpp"
#include "support/data.hpp"
#include "support/meshes.hpp"
#include "support/small_survey.hpp"

namespace cairn::pipeline {
namespace {

using geometry::Grid;
using geometry::Vec3;

class CoverageStage : public ::testing::Test {
 protected:
  testing::TempFolder folder_;
  base::RunContext ctx_;
  CoverageInputs in_{folder_ / "surface.tif", folder_ / "survey", "auto"};
  CoverageStageOptions options_;

  // Level ground at 1 m over 20 x 20 m in cells of 0.5 m; a square of 4 x 4 m was not observed.
  void SetUp() override {
    std::filesystem::create_directories(folder_ / "out");
    testing::write_small_survey(folder_ / "survey", 5);
    Grid<float> heights({0.0, 20.0, 0.5, 40, 40}, 159.0F), observed(heights.geometry, 1.0F);
    for (std::size_t r = 0; r < 8; ++r)
      for (std::size_t c = 0; c < 8; ++c) observed.at(r, c) = 0.0F;
    heights.at(39, 39) = std::numeric_limits<float>::quiet_NaN();
    const geodesy::LocalFrame frame(testing::kSmallSurveyOrigin);
    io::write_cog(folder_ / "surface.tif",
                  {{"surface", "m", "", heights, std::nullopt}, {"observed", "", "", observed, std::nullopt}},
                  frame.raster_crs_wkt());
  }
  Outcome run() { return coverage_stage(in_, folder_ / "out", options_, ctx_); }
};

const Grid<float>& band(const io::Raster& raster, std::size_t i) {
  return std::get<Grid<float>>(raster.bands.at(i).values);
}

TEST_F(CoverageStage, WritesRasterGapsAndSummary) {
  const Outcome outcome = run();
  const io::Raster views = io::read_raster(folder_ / "out/views.tif");
  ASSERT_EQ(views.bands.size(), 8U);
  EXPECT_EQ(views.bands[0].name, "views");
  EXPECT_EQ(band(views, 0).geometry, (geometry::GridGeometry{0.0, 20.0, 0.5, 40, 40}));
  EXPECT_TRUE(std::isnan(band(views, 0).at(2, 2)));    // not observed
  EXPECT_TRUE(std::isnan(band(views, 0).at(39, 39)));  // no surface
  // Frames at east 0, 5, .. 20, 19 m above the ground, see 11.4 m to each side and 8.55 m up and down.
  EXPECT_EQ(band(views, 0).at(20, 20), 5.0F);
  EXPECT_EQ(band(views, 0).at(20, 39), 3.0F);
  EXPECT_EQ(band(views, 0).at(39, 20), 0.0F);
  constexpr float kCurvature = 1e-2F;  // mm: the Earth under the tangent plane
  EXPECT_NEAR(band(views, 1).at(20, 20), 19.0F, kCurvature);
  EXPECT_TRUE(std::isnan(band(views, 1).at(39, 20)));
  EXPECT_EQ(band(views, 3).at(39, 20), 0.0F);

  const io::GapsFile gaps = io::read_gaps(folder_ / "out/gaps.json");
  EXPECT_EQ(gaps.frame.position, testing::kSmallSurveyOrigin);
  ASSERT_GE(gaps.gaps.size(), 3U);
  const auto unseen =
      std::find_if(gaps.gaps.begin(), gaps.gaps.end(), [](const auto& g) { return g.reason == "no_data"; });
  ASSERT_NE(unseen, gaps.gaps.end());
  EXPECT_NEAR(unseen->area_m2, 16.0, 1e-3);
  ASSERT_EQ(unseen->rings.size(), 1U);
  EXPECT_NEAR(geometry::signed_area(unseen->rings[0]), 16.0, 1e-3);

  const io::Json json = io::read_json(folder_ / "out/coverage.json");
  EXPECT_NEAR(json.at("area_m2").as_real(), 400.0 - 16.0 - 0.25, 1e-2);
  EXPECT_EQ(json.at("completeness").as_real(), outcome.summary.at("completeness").as_real());
  EXPECT_EQ(json.at("histograms").size(), 4U);
  double by_verdict = 0.0;
  for (const auto& [name, area] : json.at("area_m2_by_verdict").as_object()) by_verdict += area.as_real();
  EXPECT_NEAR(by_verdict, 400.0 - 0.25, 1e-2);
  double histogram = 0.0;
  for (const auto& area : json.at("histograms").as_array()[0].at("areas_m2").as_array()) histogram += area.as_real();
  EXPECT_NEAR(histogram, json.at("area_m2").as_real(), 1e-6);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/facets.csv"));
}

TEST_F(CoverageStage, AMeshIsLookedAtFromAbove) {
  // A table over the ground: the raster shows its top, not what is below.
  io::write_ply(folder_ / "mesh.ply",
                testing::joined(testing::slab(0, 0, 20, 20, 1, 20), testing::box(Vec3(8, 8, 3), Vec3(12, 12, 3.5))));
  in_.surface = folder_ / "mesh.ply";
  options_.raster_cell_m = 0.5;
  (void)run();
  const io::Raster views = io::read_raster(folder_ / "out/views.tif");
  const auto cell = *band(views, 0).geometry.cell_at({10.2, 10.2});
  // 9.9 m to each side at the height of the top: one of the five frames misses its centroids at 9.3 and 10.7 m.
  EXPECT_EQ(band(views, 0).at(cell.first, cell.second), 4.0F);
  EXPECT_NEAR(band(views, 1).at(cell.first, cell.second), 16.5F, 1e-2F);  // the top is 16.5 m below the cameras
}

TEST_F(CoverageStage, ZeroFramesCoverNothing) {
  testing::write_small_survey(folder_ / "none", 0);
  in_.views = folder_ / "none";
  const Outcome outcome = run();
  EXPECT_EQ(outcome.summary.at("completeness").as_real(), 0.0);
  EXPECT_EQ(outcome.summary.at("frames").as_integer(), 0);
  EXPECT_FALSE(ctx_.warnings().empty());
}

TEST_F(CoverageStage, RefusesWhatDoesNotFit) {
  const auto code = [&] {
    try {
      (void)run();
    } catch (const base::Error& e) {
      return e.code();
    }
    return base::ErrorCode::internal;
  };
  in_.surface = folder_ / "missing.tif";
  EXPECT_EQ(code(), base::ErrorCode::not_found);
  const Grid<float> empty({0.0, 2.0, 0.5, 4, 4}, std::numeric_limits<float>::quiet_NaN());
  const geodesy::LocalFrame frame(testing::kSmallSurveyOrigin);
  io::write_cog(folder_ / "empty.tif", {{"surface", "m", "", empty, std::nullopt}}, frame.raster_crs_wkt());
  in_.surface = folder_ / "empty.tif";
  EXPECT_EQ(code(), base::ErrorCode::invalid_input);
}

}  // namespace
}  // namespace cairn::pipeline
