#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "geodesy/local_frame.hpp"
#include "io/json.hpp"
#include "io/obstacles_json.hpp"
#include "io/packets.hpp"
#include "io/raster.hpp"
#include "io/survey_folder.hpp"
#include "io/targets_json.hpp"
#include "io/vector.hpp"
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

TEST_F(ObstaclesCommand, WritesLayersAndPackets) {
  ASSERT_EQ(run({"--terrain", terrain_.string()}).exit_code, 0);
  const auto layers = cairn::io::read_vector(out_ / "layers.gpkg");
  ASSERT_EQ(layers.size(), 2U);
  EXPECT_EQ(layers[0].name, "obstacles");
  EXPECT_EQ(layers[0].features.size(), 2U);
  EXPECT_EQ(layers[1].name, "footprints");
  EXPECT_EQ(layers[1].features.size(), 5U);
  const auto map = cairn::io::read_vector(out_ / "obstacles.geojson");
  ASSERT_EQ(map.size(), 1U);
  EXPECT_EQ(map[0].features.size(), 2U);
  // One packet a frame; the boulder is in it, the tree is not.
  const auto packets = cairn::io::read_packets(out_ / "packets.bin");
  ASSERT_EQ(packets.size(), 5U);
  for (const auto& received : packets) {
    const auto& p = received.packet;
    EXPECT_EQ(received.arrival_time_ns, p.capture_time_ns);
    ASSERT_EQ(p.objects.size(), 1U);
    EXPECT_EQ(p.objects[0].object_class, "boulder");
    EXPECT_LT((p.objects[0].position - cairn::geometry::Vec3(8, 0, 0)).norm(), 0.3);  // m; one image of 0.04 m pixels
    EXPECT_TRUE(p.vehicles.empty());
    EXPECT_GE(p.footprint.size(), 4U);
  }
}

// Seen in one image only: in no target, yet there.
TEST_F(ObstaclesCommand, ProjectsWhatIsSeenOnce) {
  auto s = cairn::io::read_survey(survey_);
  cairn::survey::Detection cone;
  cone.id = cairn::survey::DetectionId(1000);
  cone.frame = s.frames.front().id;
  cone.object_class = "cone";
  cone.box = {110.0, 500.0, 120.0, 510.0};  // at (-15.4, -0.2): in view of the first image alone
  s.detections.push_back(cone);
  cairn::survey::Detection odd = cone;
  odd.id = cairn::survey::DetectionId(1001);
  odd.object_class = "meteorite";
  odd.box = {110.0, 700.0, 120.0, 710.0};
  s.detections.push_back(odd);
  cairn::io::write_survey(s, survey_);
  const auto result = run({"--terrain", terrain_.string(), "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("meteorite"));
  const auto file = cairn::io::read_obstacles(out_ / "obstacles.json");
  ASSERT_EQ(file.obstacles.size(), 4U);
  const auto& o = file.obstacles[2];
  EXPECT_EQ(o.object_class, "cone");
  EXPECT_GT(o.target.value, file.obstacles[1].target.value);
  EXPECT_LT((o.position - cairn::geometry::Vec3(-15.4, -0.2, 0)).norm(), 0.5);  // m; leans outwards by its height
  EXPECT_EQ(o.observations, 1U);
  EXPECT_EQ(o.first_seen_ns, s.frames.front().time_ns);
  EXPECT_EQ(file.obstacles[3].kind, cairn::survey::ObstacleKind::obstacle);
  ASSERT_EQ(run({"--terrain", terrain_.string(), "--overwrite", "--project", "false"}).exit_code, 0);
  EXPECT_EQ(cairn::io::read_obstacles(out_ / "obstacles.json").obstacles.size(), 2U);
}

// Equations 1 to 3 on a plane: each box its own position, nothing fused.
TEST_F(ObstaclesCommand, PaperMode) {
  const auto result = run({"--mode", "paper", "--ground-up-m", "0", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_FALSE(fs::exists(out_ / "targets.json"));
  const auto file = cairn::io::read_obstacles(out_ / "obstacles.json");
  ASSERT_EQ(file.obstacles.size(), 10U);
  const auto s = cairn::io::read_survey(survey_);
  for (const auto& o : file.obstacles) {
    if (o.object_class != "boulder") continue;
    // The centre stands 0.5 m above the plane: r h / (H - h) too far, H / (H - h) too wide.
    bool found = false;
    for (const auto& frame : s.frames) {
      const double r = 8.0 - frame.T_world_camera.translation.x();
      found = found || std::abs(o.position.x() - (8.0 + r * 0.5 / 39.5)) < 1e-9;
    }
    EXPECT_TRUE(found);
    EXPECT_NEAR(o.width_m, 40.0 / 39.5, 1e-9);
    EXPECT_EQ(o.height_m, 0.0);
  }
}

TEST_F(ObstaclesCommand, FramesWithoutTimesStandStill) {
  auto s = cairn::io::read_survey(survey_);
  for (auto& frame : s.frames) frame.time_ns = 0;
  cairn::io::write_survey(s, survey_);
  const auto result = run({"--terrain", terrain_.string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("no times"));
  for (const auto& o : cairn::io::read_obstacles(out_ / "obstacles.json").obstacles) EXPECT_FALSE(o.velocity);
  const auto packets = cairn::io::read_packets(out_ / "packets.bin");
  ASSERT_EQ(packets.size(), 5U);
  EXPECT_LT(packets[0].packet.capture_time_ns, packets[4].packet.capture_time_ns);
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
  EXPECT_EQ(run({"--mode", "brave"}).exit_code, 2);
  EXPECT_EQ(run({"--gate-sigma", "nan"}).exit_code, 2);
  EXPECT_EQ(run({"--class-shapes", "cone:cube:1m:1"}).exit_code, 2);
  EXPECT_EQ(run({"--targets", "none.json"}).exit_code, 4);
  cairn::base::write_file(folder_ / "bad.json", "{");
  EXPECT_EQ(run({"--targets", (folder_ / "bad.json").string()}).exit_code, 4);
  EXPECT_EQ(cairn({"obstacles", "nowhere", "-o", out_.string()}).exit_code, 4);
  ASSERT_EQ(run({"--terrain", terrain_.string()}).exit_code, 0);
  EXPECT_EQ(run().exit_code, 7);
  auto empty = cairn::io::read_survey(survey_);
  empty.detections.clear();
  fs::create_directories(folder_ / "empty");
  cairn::io::write_survey(empty, folder_ / "empty");
  const auto none = cairn({"obstacles", (folder_ / "empty").string(), "-o", (folder_ / "none").string()});
  EXPECT_EQ(none.exit_code, 4);
  EXPECT_THAT(none.err, HasSubstr("no detections"));
}

}  // namespace
