#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "geodesy/local_frame.hpp"
#include "io/csv.hpp"
#include "io/json.hpp"
#include "io/ply.hpp"
#include "io/raster.hpp"
#include "io/targets_json.hpp"
#include "support/brute_force_caster.hpp"
#include "support/data.hpp"
#include "support/meshes.hpp"
#include "support/run_program.hpp"
#include "support/small_survey.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::geometry::Vec3;
using cairn::testing::cairn;
using cairn::testing::TempFolder;
using ::testing::HasSubstr;

class CoverageCommand : public ::testing::Test {
 protected:
  TempFolder folder_;
  std::string surface_ = (folder_ / "mesh.ply").string(), views_ = (folder_ / "cams.txt").string(),
              out_ = (folder_ / "out").string();
  cairn::geometry::TriangleMesh mesh_ = cairn::testing::joined(
      cairn::testing::slab(0, 0, 20, 20, 0, 10), cairn::testing::box(Vec3(8.1, 8.2, 2), Vec3(12.3, 12.4, 2.5)));

  // Two cameras straight down from 20 m, 0.7 rad to each side in x.
  void SetUp() override {
    cairn::io::write_ply(surface_, mesh_);
    cairn::base::write_file(views_,
                            "7 10 20  1 0 0  0 -1 0  0 0 -1  500 500 400 400 800 800\n"
                            "13 10 20  1 0 0  0 -1 0  0 0 -1  500 500 400 400 800 800\n");
  }
  // One target of `height` [m] at (10, 10) in the frame of the small survey.
  std::string targets_ = (folder_ / "targets.json").string();
  void write_targets(double height) const {
    cairn::survey::Target target;
    target.id = cairn::survey::TargetId(7);
    target.object_class = "boulder";
    target.state = cairn::survey::TargetState::converged;
    target.centre = Vec3(10, 10, 1);
    target.bcylinder = cairn::geometry::VerticalCylinder{{10, 10}, 0.0, height, 0.5};
    cairn::io::write_targets(targets_, {cairn::testing::small_survey(1).manifest.origin, {target}});
  }
  [[nodiscard]] ::cairn::testing::ProgramResult run(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments{"coverage", "--surface", surface_, "--views", views_, "-o", out_};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return cairn(arguments);
  }
};

TEST_F(CoverageCommand, CountsOfACameraTableEqualBruteForce) {
  const auto result = run({"--format", "pinhole-table", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = cairn::io::parse_json(result.out, "stdout");
  EXPECT_EQ(summary.at("facets").as_integer(), static_cast<std::int64_t>(mesh_.triangles.size()));
  cairn::io::CsvReader csv(fs::path(out_) / "facets.csv");
  const auto views = csv.column("views");
  std::size_t rows = 0, hidden = 0;
  while (csv.next()) {
    const Vec3 c = mesh_.centroid(rows), n = mesh_.area_vector(rows);
    std::int64_t expected = 0;
    for (const double east : {7.0, 13.0}) {
      const Vec3 d = c - Vec3(east, 10, 20);
      const bool inside = std::abs(d.x()) <= 0.8 * -d.z() && std::abs(d.y()) <= 0.8 * -d.z();
      if (!inside || n.dot(d) >= 0.0) continue;
      const bool blocked = cairn::testing::first_hit(mesh_, Vec3(east, 10, 20), d, 1.0 - 1e-4).has_value();
      expected += blocked ? 0 : 1;
      hidden += blocked ? 1 : 0;
    }
    EXPECT_EQ(csv.integer(views), expected) << "facet " << rows;
    ++rows;
  }
  EXPECT_EQ(rows, mesh_.triangles.size());
  EXPECT_GT(hidden, 5U);
  EXPECT_TRUE(fs::exists(fs::path(out_) / "run.json"));
  EXPECT_FALSE(fs::exists(fs::path(out_) / "views.tif"));  // a table has no frame on the Earth
}

TEST_F(CoverageCommand, GateDecidesTheExitCode) {
  const auto failed = run({"--min-views", "2", "--min-parallax-deg", "0", "--gate", "completeness=0.999", "--json"});
  EXPECT_EQ(failed.exit_code, 9) << failed.err;
  EXPECT_TRUE(fs::exists(fs::path(out_) / "coverage.json"));
  const auto summary = cairn::io::parse_json(failed.out, "stdout");
  EXPECT_FALSE(summary.at("gate_passed").as_bool());
  EXPECT_EQ(run({"--min-views", "2", "--gate", "completeness=0.1", "--overwrite"}).exit_code, 0);
  EXPECT_EQ(run({"--gate", "completeness=2", "--overwrite"}).exit_code, 2);
  EXPECT_EQ(run({"--gate", "beauty=0.5", "--overwrite"}).exit_code, 2);
}

TEST_F(CoverageCommand, TargetsAndQueriesAreAnswered) {
  write_targets(1.5);
  const auto result = run({"--targets", targets_, "--point", "10,10", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = cairn::io::parse_json(result.out, "stdout");
  EXPECT_EQ(summary.at("targets").at("audited").as_integer(), 1);
  EXPECT_EQ(summary.at("targets").at("passed").as_integer(), 0);
  EXPECT_NEAR(summary.at("points").as_array()[0].at("up_m").as_real(), 2.5, 1e-4);  // the top of the box
  EXPECT_EQ(summary.at("points").as_array()[0].at("seen_by").as_integer(), 2);
  EXPECT_THAT(run({"--targets", targets_, "--overwrite"}).out, HasSubstr("0 of 1 targets pass"));
  // A cylinder of zero height is said, not judged.
  write_targets(0.0);
  ASSERT_EQ(run({"--targets", targets_, "--overwrite"}).exit_code, 0);
  EXPECT_THAT(cairn::base::read_file(fs::path(out_) / "run.json"), HasSubstr("cylinder_without_height"));
  EXPECT_EQ(run({"--point", "somewhere", "--overwrite"}).exit_code, 2);
  EXPECT_EQ(run({"--point", "500,500", "--overwrite"}).exit_code, 4);
  EXPECT_EQ(run({"--contacts", targets_, "--overwrite"}).exit_code, 2);
  EXPECT_EQ(run({"--targets", (folder_ / "none.json").string(), "--overwrite"}).exit_code, 4);
}

TEST_F(CoverageCommand, RefusesAnExistingOutput) {
  ASSERT_EQ(run().exit_code, 0);
  EXPECT_EQ(run().exit_code, 7);
  EXPECT_EQ(run({"--overwrite"}).exit_code, 0);
}

TEST_F(CoverageCommand, SameBytesForAnyThreadCount) {
  const ::cairn::geodesy::LocalFrame frame(cairn::testing::kSmallSurveyOrigin);
  cairn::geometry::Grid<float> heights({0.0, 20.0, 0.1, 200, 200}, 0.0F);
  for (std::size_t r = 0; r < 200; ++r)
    for (std::size_t c = 0; c < 200; ++c) {
      const auto p = heights.geometry.centre(r, c);
      heights.at(r, c) = static_cast<float>(158.0 + std::sin(2.0 * p.x()) * std::cos(1.7 * p.y()));
    }
  surface_ = (folder_ / "surface.tif").string();
  views_ = (folder_ / "survey").string();
  cairn::io::write_cog(surface_, {{"surface", "m", "", heights, std::nullopt}}, frame.raster_crs_wkt());
  cairn::testing::write_small_survey(views_, 5);
  ASSERT_EQ(run(with({"--threads", "1"})).exit_code, 0);
  std::vector<std::string> one;
  write_targets(1.0);
  const std::vector<std::string> products = {"coverage.json", "facets.csv",           "gaps.json",
                                             "views.tif",     "audit.html",           "coverage.gpkg",
                                             "coverage.ply",  "coverage.glb",         "points.json",
                                             "viewshed.csv",  "targets_coverage.csv", "targets_coverage.json",
                                             "viewshed.tif",  "frames_coverage.csv"};
  const std::vector<std::string> queries = {"--targets", targets_, "--point", "10,10", "--viewshed", "3,4"};
  const auto with = [&queries](std::vector<std::string> more) {
    more.insert(more.end(), queries.begin(), queries.end());
    return more;
  };
  for (const auto& name : products) one.push_back(cairn::base::read_file(fs::path(out_) / name));
  ASSERT_EQ(run(with({"--threads", "4", "--overwrite"})).exit_code, 0);
  for (std::size_t i = 0; i < products.size(); ++i)
    EXPECT_EQ(cairn::base::read_file(fs::path(out_) / products[i]), one[i]) << products[i];
}

TEST_F(CoverageCommand, BadInputNamesItAndLeavesNothing) {
  const auto refused = [&](int code, const std::string& word) {
    const auto result = run();
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_THAT(result.err, HasSubstr(word));
    EXPECT_FALSE(fs::exists(out_));
  };
  const std::string good = cairn::base::read_file(views_);
  cairn::base::write_file(views_, good + "1 2 3\n");
  refused(4, "line 3");
  cairn::base::write_file(views_, good);
  const std::string mesh = cairn::base::read_file(surface_);
  cairn::base::write_file(surface_, mesh.substr(0, mesh.size() / 2));
  refused(4, "mesh.ply");
  surface_ = (folder_ / "none.ply").string();
  refused(4, "none.ply");
  EXPECT_EQ(cairn({"coverage", "-o", out_}).exit_code, 2);
}

}  // namespace
