#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "io/json.hpp"
#include "io/ply.hpp"
#include "io/survey_folder.hpp"
#include "io/targets_json.hpp"
#include "io/tracks_csv.hpp"
#include "support/data.hpp"
#include "support/nadir_survey.hpp"
#include "support/run_program.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::testing::cairn;
using cairn::testing::NadirSurvey;
using cairn::testing::TempFolder;
using ::testing::HasSubstr;

class LocateCommand : public ::testing::Test {
 protected:
  TempFolder folder_;
  fs::path survey_ = folder_ / "survey", out_ = folder_ / "out";

  void write(NadirSurvey s) const {
    s.survey.manifest.name = "made up";
    s.survey.manifest.origin.position = {46.8426, -91.994, 158.0};
    s.survey.manifest.origin.height_type = cairn::survey::HeightType::ellipsoidal;
    fs::create_directories(survey_);
    cairn::io::write_survey(s.survey, survey_);
  }
  void SetUp() override {
    NadirSurvey s(5, 4.0);
    s.object({8, 0, 0.5});
    s.object({10, 4, 0.5}, 2.0, "car");
    s.box(cairn::survey::FrameId(1), {500, 500, 500, 520}, "boulder");
    write(s);
  }
  [[nodiscard]] cairn::testing::ProgramResult run(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments{"locate", survey_.string(), "--ground-up-m", "0", "-o", out_.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return cairn(arguments);
  }
};

TEST_F(LocateCommand, WritesTargetsEvidenceLayersAndRecord) {
  const auto result = run({"--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = cairn::io::parse_json(result.out, "stdout");
  EXPECT_EQ(summary.at("converged").as_integer(), 2);
  EXPECT_EQ(summary.at("depth_source").as_string(), "ground");
  EXPECT_EQ(summary.at("rejects_by_reason").at("zero_area_box").as_integer(), 1);
  const auto targets = cairn::io::read_targets(out_ / "targets.json");
  ASSERT_EQ(targets.targets.size(), 2U);
  EXPECT_LT((targets.targets[0].centre - cairn::geometry::Vec3(8, 0, 0.5)).norm(), 1e-6);
  EXPECT_EQ(cairn::io::read_ply_cloud(out_ / "points/1.ply").cloud.size(), 2000U);
  EXPECT_THAT(cairn::base::read_file(out_ / "plots/1.svg"), HasSubstr("differential entropy"));
  ASSERT_FALSE(targets.targets[0].history.empty());
  EXPECT_EQ(targets.targets[0].history.back().state, cairn::survey::TargetState::converged);
  for (const auto* name : {"layers.gpkg", "target_evidence.csv", "run.json"})
    EXPECT_TRUE(fs::exists(out_ / name)) << name;
  EXPECT_THAT(cairn::base::read_file(out_ / "run.json"), HasSubstr("zero_area_box"));
}

TEST_F(LocateCommand, LeavesPointsAndPlotsOut) {
  ASSERT_EQ(run({"--no-points", "--no-plots"}).exit_code, 0);
  EXPECT_FALSE(fs::exists(out_ / "points"));
  EXPECT_FALSE(fs::exists(out_ / "plots"));
}

TEST_F(LocateCommand, TakesTracks) {
  const auto survey = cairn::io::read_survey(survey_);
  std::vector<cairn::survey::TrackedBox> rows;
  for (const auto& d : survey.detections)
    if (d.object_class == "car") rows.push_back({cairn::survey::TrackId(7), cairn::survey::TrackState::detected, d});
  ASSERT_GE(rows.size(), 3U);
  const fs::path tracks = folder_ / "tracks.csv";
  cairn::io::write_tracks(tracks, rows);
  const auto result = run({"--json", "--tracks", tracks.string(), "--generation-boxes", "2"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = cairn::io::parse_json(result.out, "stdout");
  EXPECT_GT(summary.at("rejects_by_reason").at("unregistered").as_integer(), 0);
  const auto targets = cairn::io::read_targets(out_ / "targets.json");
  ASSERT_EQ(targets.targets.size(), 1U);
  EXPECT_EQ(targets.targets[0].object_class, "car");
  EXPECT_THAT(cairn::base::read_file(out_ / "run.json"), HasSubstr("tracks.csv"));
  EXPECT_EQ(run({"--tracks", "none.csv", "--overwrite"}).exit_code, 4);
}

TEST_F(LocateCommand, PaperModeSaysWhatItsCovarianceIs) {
  ASSERT_EQ(run({"--mode", "paper", "--max-depth-m", "42"}).exit_code, 0);
  const auto targets = cairn::io::read_targets(out_ / "targets.json");
  ASSERT_FALSE(targets.targets.empty());
  EXPECT_THAT(targets.targets[0].reasons, ::testing::Contains("covariance_is_spread"));
}

TEST_F(LocateCommand, SameBytesForAnyThreadCount) {
  ASSERT_EQ(run({"--threads", "1"}).exit_code, 0);
  const auto one = cairn::base::read_file(out_ / "targets.json") + cairn::base::read_file(out_ / "target_evidence.csv");
  ASSERT_EQ(run({"--threads", "4", "--overwrite"}).exit_code, 0);
  EXPECT_EQ(cairn::base::read_file(out_ / "targets.json") + cairn::base::read_file(out_ / "target_evidence.csv"), one);
}

TEST_F(LocateCommand, RefusesAnExistingOutput) {
  ASSERT_EQ(run().exit_code, 0);
  EXPECT_EQ(run().exit_code, 7);
}

TEST_F(LocateCommand, BadInput) {
  EXPECT_EQ(run({"--min-hit-ratio", "2"}).exit_code, 2);
  EXPECT_EQ(run({"--min-depth-m", "9", "--max-depth-m", "3"}).exit_code, 2);
  EXPECT_EQ(run({"--terrain", "none.tif"}).exit_code, 4);
  EXPECT_EQ(cairn({"locate", "nowhere", "-o", out_.string()}).exit_code, 4);
  cairn::base::write_file(
      survey_ / "detections.csv",
      "detection_id,frame_id,class,score,xmin_px,ymin_px,xmax_px,ymax_px\n1,99,boulder,1,0,0,5,5\n");
  const auto unknown = run();
  EXPECT_EQ(unknown.exit_code, 4);
  EXPECT_THAT(unknown.err, HasSubstr("detections.csv"));
  fs::remove(survey_ / "detections.csv");
  const auto none = run();
  EXPECT_EQ(none.exit_code, 4);
  EXPECT_THAT(none.err, HasSubstr("no detections"));
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(LocateCommand, DryRunWritesNothing) {
  const auto result = run({"--dry-run", "--json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(cairn::io::parse_json(result.out, "stdout").at("frames").as_integer(), 5);
  EXPECT_FALSE(fs::exists(out_));
}

}  // namespace
