#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "io/csv.hpp"
#include "io/json.hpp"
#include "io/survey_folder.hpp"
#include "support/block_survey.hpp"
#include "support/data.hpp"
#include "support/run_program.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::testing::BlockSurvey;
using cairn::testing::cairn;
using cairn::testing::TempFolder;
using ::testing::HasSubstr;

class RefineCommand : public ::testing::Test {
 protected:
  TempFolder folder_;
  fs::path survey_ = folder_ / "survey", out_ = folder_ / "nested" / "out";
  BlockSurvey block_{{.columns = 3, .rows = 2, .points = 150, .noise_px = 0.3}};

  void write(const cairn::adjustment::BundleProblem& problem) const {
    cairn::survey::Survey s;
    s.manifest.name = "made up";
    s.manifest.origin.position = {46.8426, -91.994, 158.0};
    s.manifest.origin.height_type = cairn::survey::HeightType::ellipsoidal;
    s.manifest.cameras = problem.cameras;
    cairn::survey::Source poses;
    poses.kind = "poses";
    poses.convention = "Made up.";
    poses.crs = "local";
    s.manifest.sources.push_back(poses);
    s.frames = problem.frames;
    for (auto& frame : s.frames) frame.image = "images/" + std::to_string(frame.id.value) + ".jpg";
    s.ties = problem.ties;
    for (auto& tie : s.ties) tie.p_world.setZero();  // of no use as a start
    cairn::survey::Detection box;
    box.id = cairn::survey::DetectionId(1);
    box.frame = problem.frames.front().id;
    box.object_class = "boulder";
    box.score = 0.5;
    box.box = {10, 10, 20, 20};
    s.detections.push_back(box);
    fs::create_directories(survey_);
    cairn::io::write_survey(s, survey_);
  }
  void SetUp() override {
    fs::create_directories(out_.parent_path());
    write(block_.perturbed(0.3, 0.5, 3));
  }
  [[nodiscard]] cairn::testing::ProgramResult run(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments{"refine", survey_.string(), "-o", out_.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return cairn(arguments);
  }
};

TEST_F(RefineCommand, WritesACompleteSurveyBesideTheOldOne) {
  const auto old_frames = cairn::base::read_file(survey_ / "frames.csv");
  const auto result = run({"--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = cairn::io::parse_json(result.out, "stdout");
  EXPECT_EQ(summary.at("frames_adjusted").as_integer(), 6);
  EXPECT_EQ(summary.at("gauge").as_string(), "aligned");
  EXPECT_TRUE(summary.at("converged").as_bool());
  EXPECT_GT(summary.at("rms_before_px").as_real(), 3.0);
  EXPECT_LT(summary.at("rms_after_px").as_real(), 0.6);
  EXPECT_EQ(summary.at("frame_table").size(), 6U);
  EXPECT_EQ(cairn::base::read_file(survey_ / "frames.csv"), old_frames);

  const auto refined = cairn::io::read_survey(out_);
  EXPECT_EQ(refined.frames.size(), 6U);
  EXPECT_EQ(refined.detections.size(), 1U);
  EXPECT_GT(refined.ties.size(), 100U);
  EXPECT_EQ(cairn::io::resolve_reference(refined.frames[0].image, out_).lexically_normal(),
            (survey_ / "images/10.jpg").lexically_normal());
  EXPECT_GT(refined.frames[0].sigma_xy_m, 0.0);
  EXPECT_LT(refined.frames[0].sigma_rot_deg, 0.5);
  EXPECT_THAT(refined.manifest.notes.back(), HasSubstr("bundle adjustment"));
  cairn::io::CsvReader table(out_ / "refine_frames.csv");
  int rows = 0;
  while (table.next()) {
    ++rows;
    EXPECT_EQ(table.text(table.column("state")), "adjusted");
    EXPECT_LT(table.real(table.column("rms_after_px")), table.real(table.column("rms_before_px")));
  }
  EXPECT_EQ(rows, 6);
}

TEST_F(RefineCommand, ControlPointsBringTheSurveyBack) {
  auto shifted = block_.perturbed(0.3, 0.5, 3);
  for (auto& frame : shifted.frames) frame.T_world_camera.translation += cairn::geometry::Vec3(3, -2, 1);
  write(shifted);
  std::string table = "# crs: local\nname,x,y,z,image,x_px,y_px,use\n";
  cairn::base::Random random(1, "control", 0);
  const double places[5][3] = {{0, 0, 0}, {24, 0, 1}, {0, 12, 2}, {24, 12, 0}, {12, 6, 1}};
  for (int i = 0; i < 5; ++i)
    for (const auto& seen : block_.seen({places[i][0], places[i][1], places[i][2]}, random, 0.3)) {
      table += "p" + std::to_string(i + 1);
      for (const double v : places[i]) table += "," + std::to_string(v);
      table += "," + std::to_string(seen.frame.value) + ".jpg," + std::to_string(seen.pixel.x()) + "," +
               std::to_string(seen.pixel.y()) + (i == 4 ? ",check\n" : ",control\n");
    }
  const fs::path file = folder_ / "control.csv";
  cairn::base::write_file(file, table);
  const auto result = run({"--control", file.string(), "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = cairn::io::parse_json(result.out, "stdout");
  EXPECT_EQ(summary.at("gauge").as_string(), "control");
  const auto& points = summary.at("control_points").as_array();
  ASSERT_EQ(points.size(), 5U);
  for (const auto& point : points) {
    EXPECT_GT(point.at("before_m").as_vec3().norm(), 2.0);
    EXPECT_LT(point.at("after_m").as_vec3().norm(), 0.1);
  }
  EXPECT_EQ(points[4].at("use").as_string(), "check");
  EXPECT_NE(cairn::io::read_survey(out_).manifest.source("control_points"), nullptr);

  EXPECT_EQ(run({"--overwrite", "--control", "nowhere.csv"}).exit_code, 4);
  EXPECT_EQ(run({"--overwrite", "--control", file.string(), "--control-crs", "EPSG:0"}).exit_code, 6);
}

TEST_F(RefineCommand, SameBytesForAnyThreadCount) {
  const auto bytes = [&] {
    std::string all;
    for (const auto* name : {"frames.csv", "tie_points.csv", "refine_frames.csv", "survey.json"})
      all += cairn::base::read_file(out_ / name);
    return all;
  };
  ASSERT_EQ(run({"--threads", "1"}).exit_code, 0);
  const auto one = bytes();
  ASSERT_EQ(run({"--threads", "4", "--overwrite"}).exit_code, 0);
  EXPECT_EQ(bytes(), one);
}

TEST_F(RefineCommand, PrintsNothingButItsSummary) {
  const auto result = run();
  ASSERT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, HasSubstr("6 of 6 frames adjusted"));
  EXPECT_EQ(result.err, "");
}

TEST_F(RefineCommand, BadInput) {
  EXPECT_EQ(run({"--intrinsics", "everything"}).exit_code, 2);
  EXPECT_EQ(run({"--loss-scale", "-1"}).exit_code, 2);
  EXPECT_EQ(cairn({"refine", "nowhere", "-o", out_.string()}).exit_code, 4);
  auto unjoined = block_.truth;
  for (auto& tie : unjoined.ties) tie.observations.resize(1);
  write(unjoined);
  const auto alone = run();
  EXPECT_EQ(alone.exit_code, 4);
  EXPECT_THAT(alone.err, HasSubstr("share enough tie points"));
  fs::remove(survey_ / "tie_points.csv");
  fs::remove(survey_ / "tie_observations.csv");
  const auto none = run();
  EXPECT_EQ(none.exit_code, 4);
  EXPECT_THAT(none.err, HasSubstr("no tie points"));
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(RefineCommand, RefusesAnExistingOutput) {
  ASSERT_EQ(run().exit_code, 0);
  EXPECT_EQ(run().exit_code, 7);
}

TEST_F(RefineCommand, DryRunWritesNothing) {
  const auto result = run({"--dry-run", "--json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(cairn::io::parse_json(result.out, "stdout").at("frames").as_integer(), 6);
  EXPECT_FALSE(fs::exists(out_));
}

}  // namespace
