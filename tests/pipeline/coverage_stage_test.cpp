#include "pipeline/coverage_stage.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "geodesy/local_frame.hpp"
#include "io/contact_csv.hpp"
#include "io/csv.hpp"
#include "io/gaps_json.hpp"
#include "io/mesh.hpp"
#include "io/ply.hpp"
#include "io/raster.hpp"
#include "io/targets_json.hpp"
#include "io/vector.hpp"
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
  CoverageInputs in_{folder_ / "surface.tif", folder_ / "survey", "auto", {}, {}, {}, {}};
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

TEST_F(CoverageStage, SaysHowUncertainItIsAndWhatSidesAre) {
  (void)run();
  const io::Json json = io::read_json(folder_ / "out/coverage.json");
  const double completeness = json.at("completeness").as_real();
  const auto& interval = json.at("completeness_interval_95").as_array();
  EXPECT_LT(interval[0].as_real(), completeness);
  EXPECT_GT(interval[1].as_real(), completeness);
  EXPECT_EQ(json.at("sides").at("area_m2").as_real(), 0.0);  // level ground has none
  EXPECT_EQ(json.at("sides").find("completeness"), nullptr);
  // Twenty metres up, 0.5 px and 2 cm of pose: some centimetres of depth.
  EXPECT_GT(json.at("sigma_max_mm").at("median").as_real(), 5.0);
  EXPECT_LT(json.at("sigma_max_mm").at("median").as_real(), 200.0);
  EXPECT_EQ(json.at("blur").at("known").as_integer(), 0);  // no images, no times
}

TEST_F(CoverageStage, OneLargeFacetHidesNoGap) {
  // Two triangles of 20 x 20 m; the centroids are seen by all, the northern and southern borders by none.
  io::write_ply(folder_ / "mesh.ply", testing::slab(0, 0, 20, 20, 1, 1));
  in_.surface = folder_ / "mesh.ply";
  options_.facets_csv = true;
  const Outcome outcome = run();
  EXPECT_GT(outcome.summary.at("samples").as_integer(), 800);
  EXPECT_EQ(outcome.summary.at("facets").as_integer(), 2);
  // The strip of 17.1 m that the frames see, less what three of them do not reach.
  EXPECT_GT(outcome.summary.at("completeness").as_real(), 0.6);
  EXPECT_LT(outcome.summary.at("completeness").as_real(), 0.9);
  io::CsvReader csv(folder_ / "out/facets.csv");
  while (csv.next()) {
    EXPECT_GE(csv.integer(csv.column("views")), 3);
    EXPECT_GT(csv.real(csv.column("passed_share")), 0.4);
    EXPECT_LT(csv.real(csv.column("passed_share")), 0.99);
  }
  options_.sample_edge_m = 0.0;
  std::filesystem::remove_all(folder_ / "out");
  std::filesystem::create_directories(folder_ / "out");
  EXPECT_EQ(run().summary.at("completeness").as_real(), 1.0);
}

survey::Target target_at(std::int64_t id, double east, double north, double radius, double height) {
  survey::Target target;
  target.id = survey::TargetId(id);
  target.object_class = "boulder";
  target.state = survey::TargetState::converged;
  target.centre = Vec3(east, north, 1.0 + 0.5 * height);
  target.bcylinder = geometry::VerticalCylinder{{east, north}, 1.0, 1.0 + height, radius};
  return target;
}

TEST_F(CoverageStage, TargetsGetRowsOfTheirOwn) {
  survey::Target given_up = target_at(3, 15, 10, 1, 1);
  given_up.state = survey::TargetState::deregistered;
  survey::Target flat = target_at(4, 5, 10, 1, 0), unknown = target_at(5, 5, 12, 1, 1);
  unknown.bcylinder.reset();
  io::write_targets(folder_ / "targets.json", {testing::small_survey(5).manifest.origin,
                                               {target_at(1, 10, 10, 0.5, 1.0), given_up, flat, unknown}});
  in_.targets = folder_ / "targets.json";
  io::ContactFile contacts;
  contacts.crs = "local";
  for (int i = 0; i < 4; ++i)
    contacts.rows.push_back(
        {1, {0, i, Vec3(i == 1 || i == 2 ? 10.5 : 9.5, i > 1 ? 10.5 : 9.5, 1.0), true, true, 0.01}});
  io::write_contact_csv(folder_ / "contact.csv", contacts);
  in_.contacts = folder_ / "contact.csv";
  const Outcome outcome = run();
  EXPECT_EQ(outcome.summary.at("targets").at("audited").as_integer(), 1);
  EXPECT_EQ(outcome.summary.at("targets").at("passed").as_integer(), 0);
  ASSERT_EQ(outcome.rejects.size(), 2U);
  EXPECT_EQ(outcome.rejects[0].reason, "no_cylinder");
  EXPECT_EQ(outcome.rejects[1].reason, "cylinder_without_height");
  io::CsvReader csv(folder_ / "out/targets_coverage.csv");
  ASSERT_TRUE(csv.next());
  EXPECT_EQ(csv.integer(csv.column("target_id")), 1);
  EXPECT_EQ(csv.text(csv.column("passed")), "false");
  EXPECT_EQ(csv.text(csv.column("basal_contact_known")), "true");
  EXPECT_NEAR(csv.real(csv.column("basal_perimeter_m")), 4.0, 1e-9);
  EXPECT_LT(csv.real(csv.column("wall_completeness")), 0.5);
  EXPECT_FALSE(csv.next());
  const io::Json json = io::read_json(folder_ / "out/targets_coverage.json");
  EXPECT_EQ(json.at("targets").as_array()[0].at("wall_by_azimuth").size(), coverage::kSectors);
}

TEST_F(CoverageStage, CylindersMayBeTheSurface) {
  io::write_targets(folder_ / "targets.json", {testing::small_survey(5).manifest.origin,
                                               {target_at(1, 10, 10, 0.5, 1.0), target_at(2, 10, 12, 0.5, 0.0)}});
  in_.surface = in_.targets = folder_ / "targets.json";
  const Outcome outcome = run();
  EXPECT_NEAR(outcome.summary.at("area_m2").as_real(), 3.14159 + 0.785398, 0.01);
  EXPECT_NEAR(outcome.summary.at("sides").at("area_m2").as_real(), 3.14159, 0.01);
  EXPECT_EQ(outcome.summary.at("targets").at("audited").as_integer(), 1);
}

TEST_F(CoverageStage, ACloudBecomesASurface) {
  geometry::PointCloud cloud;
  for (int i = 0; i < 80; ++i)
    for (int j = 0; j < 80; ++j) cloud.positions.emplace_back(0.125 + 0.25 * i, 0.125 + 0.25 * j, 1.0);
  io::write_ply(folder_ / "cloud.ply", cloud);
  in_.surface = folder_ / "cloud.ply";
  const Outcome outcome = run();
  EXPECT_NEAR(outcome.summary.at("area_m2").as_real(), 400.0, 2.0);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/views.tif"));
}

TEST_F(CoverageStage, FacetsThatWereClosedAreNoData) {
  geometry::TriangleMesh mesh = testing::slab(8, 8, 12, 12, 1, 4);
  mesh.colours.assign(mesh.vertices.size(), {168, 150, 126});
  for (const auto v : mesh.triangles[0]) mesh.colours[v] = {196, 96, 70};
  io::write_ply(folder_ / "rock.ply", mesh);
  in_.surface = folder_ / "rock.ply";
  EXPECT_NEAR(run().summary.at("area_m2_by_verdict").at("no_data").as_real(), 0.5, 1e-9);
}

TEST_F(CoverageStage, WritesPageLayersAndColouredMeshOnRequest) {
  options_.page = options_.layers = true;
  options_.colour_mesh = "views";
  (void)run();
  const std::string page = base::read_file(folder_ / "out/audit.html");
  EXPECT_NE(page.find("<h2>Maps</h2>"), std::string::npos);
  EXPECT_EQ(page.find(">nan"), std::string::npos);
  const auto layers = io::vector_info(folder_ / "out/coverage.gpkg");
  ASSERT_EQ(layers.size(), 3U);
  EXPECT_EQ(layers[0].name, "frames");
  EXPECT_EQ(layers[0].feature_count, 5U);
  EXPECT_EQ(layers[1].name, "footprints");
  EXPECT_EQ(layers[2].name, "gaps");
  EXPECT_EQ(layers[2].feature_count, io::read_gaps(folder_ / "out/gaps.json").gaps.size());
  const io::MeshData painted = io::read_mesh(folder_ / "out/coverage.ply");
  EXPECT_EQ(painted.mesh.triangles.size(), 2U * (40 * 40 - 1));
  EXPECT_EQ(painted.mesh.colours.size(), painted.mesh.vertices.size());
  EXPECT_GT(std::filesystem::file_size(folder_ / "out/coverage.glb"), 10000U);
}

TEST_F(CoverageStage, AnswersWhoSawAPointAndWhatIsSeenFromOne) {
  in_.points = {"10,10", "10,19.5,1.0", "10,10,0.5"};
  in_.viewsheds = {"10,10,5", "10,10,-5"};
  const Outcome outcome = run();
  const auto& points = outcome.summary.at("points").as_array();
  EXPECT_NEAR(points[0].at("up_m").as_real(), 1.0, 1e-3);
  EXPECT_EQ(points[0].at("seen_by").as_integer(), 5);
  EXPECT_EQ(points[1].at("seen_by").as_integer(), 0);  // beyond the frames' border
  EXPECT_EQ(points[2].at("seen_by").as_integer(), 0);  // in the ground
  const auto& eyes = outcome.summary.at("viewsheds").as_array();
  EXPECT_NEAR(eyes[0].at("seen_area_m2").as_real(), 400.0 - 0.25, 1e-2);
  EXPECT_EQ(eyes[1].at("seen_area_m2").as_real(), 0.0);
  const io::Json json = io::read_json(folder_ / "out/points.json");
  EXPECT_EQ(json.at("points").as_array()[2].at("frames").as_array()[0].at("sight").as_string(), "occluded");
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/viewshed.tif"));
  for (const char* bad : {"10", "a,b", "1,2,3,4", "1,nan", "100,100"}) {
    in_.points = {bad};
    EXPECT_THROW((void)run(), base::Error) << bad;
  }
}

TEST_F(CoverageStage, HeightsOfAnotherDatumAreRefused) {
  const geodesy::LocalFrame frame(testing::kSmallSurveyOrigin);
  const auto with = [&](const std::string& description, float height) {
    const Grid<float> heights({0.0, 20.0, 0.5, 40, 40}, height);
    io::write_cog(folder_ / "named.tif", {{"surface", "m", description, heights, std::nullopt}},
                  frame.raster_crs_wkt());
    in_.surface = folder_ / "named.tif";
  };
  with("highest points of each cell, ellipsoidal height", 159.0F);
  EXPECT_GT(run().summary.at("completeness").as_real(), 0.0);
  with("highest points of each cell, orthometric (egm96) height", 159.0F);
  try {
    (void)run();
    FAIL() << "another datum was taken";
  } catch (const base::Error& e) {
    EXPECT_EQ(e.code(), base::ErrorCode::crs_mismatch);
  }
  // Where nobody says it, cameras below the surface are told.
  with("heights", 250.0F);
  const Outcome outcome = run();
  EXPECT_GE(outcome.summary.at("frames_below_surface").as_integer(), 3);  // two stand over its border
  EXPECT_EQ(outcome.summary.at("completeness").as_real(), 0.0);
  EXPECT_NE(ctx_.warnings().back().find("below the surface"), std::string::npos);
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
