#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "geodesy/local_frame.hpp"
#include "io/json.hpp"
#include "io/obstacles_json.hpp"
#include "io/raster.hpp"
#include "io/survey_folder.hpp"
#include "io/targets_json.hpp"
#include "support/data.hpp"
#include "support/nadir_survey.hpp"
#include "support/run_program.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::testing::cairn;
using cairn::testing::NadirSurvey;
using cairn::testing::TempFolder;
using ::testing::HasSubstr;

const cairn::geometry::Geodetic kOrigin{46.8426, -91.994, 158.0};

class ObstaclesCommand : public ::testing::Test {
 protected:
  TempFolder folder_;
  fs::path survey_ = folder_ / "survey", out_ = folder_ / "out", terrain_ = folder_ / "surface.tif";

  void SetUp() override {
    NadirSurvey s(5, 4.0);
    s.object({8, 0, 0.5}, 1.0, "boulder");
    s.object({12, 5, 2.0}, 3.0, "tree");
    s.survey.manifest.name = "made up";
    s.survey.manifest.origin.position = kOrigin;
    s.survey.manifest.origin.height_type = cairn::survey::HeightType::ellipsoidal;
    for (const double east : {8.0, 12.0})
      s.survey.ties.push_back({cairn::survey::TiePointId(east > 10 ? 2 : 1), {east, 0, 0}, {}});
    fs::create_directories(survey_);
    cairn::io::write_survey(s.survey, survey_);
    // Level ground at up = 0, on cells whose heights are ellipsoidal.
    const cairn::geodesy::LocalFrame frame(kOrigin);
    cairn::geometry::Grid<float> ground({-30.0, 40.0, 0.5, 160, 160}, 158.0F);
    cairn::io::write_cog(terrain_, {{"ground", "m", "test", ground, std::nullopt}}, frame.raster_crs_wkt());
  }
  [[nodiscard]] cairn::testing::ProgramResult run(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments{"obstacles", survey_.string(), "-o", out_.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return cairn(arguments);
  }
};

TEST_F(ObstaclesCommand, LocatesAndMeasures) {
  const auto result = run({"--terrain", terrain_.string(), "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = cairn::io::parse_json(result.out, "stdout");
  EXPECT_EQ(summary.at("obstacle").as_integer(), 1);
  EXPECT_EQ(summary.at("ignored").as_integer(), 1);
  EXPECT_EQ(summary.at("without_ground").as_integer(), 0);
  const auto file = cairn::io::read_obstacles(out_ / "obstacles.json");
  ASSERT_EQ(file.obstacles.size(), 2U);
  const auto& boulder = file.obstacles[0];
  EXPECT_EQ(boulder.object_class, "boulder");
  EXPECT_LT((boulder.position - cairn::geometry::Vec3(8, 0, 0)).norm(), 0.01);  // m; heights are floats at 158 m
  EXPECT_NEAR(boulder.height_m, 1.0, 0.01);
  // Boxes of 1 m: what the height adds to the outline, off the axis, is taken out again.
  EXPECT_GT(boulder.width_m, 0.8);
  EXPECT_LE(boulder.width_m, 1.0 + 1e-9);
}

TEST_F(ObstaclesCommand, TakesTargetsThatAreThere) {
  const auto located = folder_ / "located";
  ASSERT_EQ(cairn({"locate", survey_.string(), "--ground-up-m", "0", "-o", located.string()}).exit_code, 0);
  const auto result = run({"--targets", (located / "targets.json").string(), "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_FALSE(fs::exists(out_ / "targets.json"));
  EXPECT_EQ(cairn::io::parse_json(result.out, "stdout").at("without_ground").as_integer(), 2);
  EXPECT_THAT(result.err, HasSubstr("no ground"));
}

TEST_F(ObstaclesCommand, RefusesAnotherFrame) {
  auto targets = cairn::io::TargetsFile{};
  targets.frame.position = {10.0, 20.0, 0.0};
  targets.frame.height_type = cairn::survey::HeightType::ellipsoidal;
  cairn::io::write_targets(folder_ / "elsewhere.json", targets);
  EXPECT_EQ(run({"--targets", (folder_ / "elsewhere.json").string()}).exit_code, 6);
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(ObstaclesCommand, BadInput) {
  EXPECT_EQ(run({"--least-state", "mapped"}).exit_code, 2);
  EXPECT_EQ(run({"--targets", "none.json"}).exit_code, 4);
  cairn::base::write_file(folder_ / "bad.json", "{");
  EXPECT_EQ(run({"--targets", (folder_ / "bad.json").string()}).exit_code, 4);
  EXPECT_EQ(cairn({"obstacles", "nowhere", "-o", out_.string()}).exit_code, 4);
  ASSERT_EQ(run({"--terrain", terrain_.string()}).exit_code, 0);
  EXPECT_EQ(run().exit_code, 7);
}

}  // namespace
