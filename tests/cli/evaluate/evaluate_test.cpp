#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/atomic_file.hpp"
#include "io/json.hpp"
#include "io/ply.hpp"
#include "io/survey_folder.hpp"
#include "io/targets_json.hpp"
#include "io/tracks_csv.hpp"
#include "io/truth.hpp"
#include "support/data.hpp"
#include "support/meshes.hpp"
#include "support/nadir_survey.hpp"
#include "support/run_program.hpp"

namespace {

namespace fs = std::filesystem;
using namespace cairn;
using cairn::testing::cairn;
using cairn::testing::NadirSurvey;
using cairn::testing::TempFolder;
using geometry::Vec3;
using io::Json;
using survey::ObjectId;
using ::testing::HasSubstr;

// Five photos from above. Two sought rocks (objects 1 and 2), cubes of 2 m; recorded positions are 1 m off to the east.
class EvaluateCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    NadirSurvey made(5, 4.0);
    made.object({8, 0, 1.0});
    made.object({10, 4, 1.0});
    made.survey.manifest.name = "made up";
    made.survey.manifest.origin.position = {46.8426, -91.994, 158.0};
    made.survey.manifest.origin.height_type = survey::HeightType::ellipsoidal;
    survey_ = made.survey;
    truth_.scene = "made up";
    for (const int k : {1, 2}) {
      survey::TruthObject object;
      object.id = ObjectId(k);
      object.object_class = survey_.detections.front().object_class;
      object.sought = true;
      const geometry::Vec2 at = k == 1 ? geometry::Vec2(8, 0) : geometry::Vec2(10, 4);
      object.cylinder = {at, 0.0, 2.0, std::sqrt(2.0)};
      object.mesh = io::truth_mesh_name(object.id);
      truth_.objects.push_back(object);
    }
    for (auto& frame : survey_.frames) frame.time_ns = frame.id.value * 10'000'000'000LL;  // photos
    truth_.frames = survey_.frames;
    for (auto& frame : survey_.frames) frame.T_world_camera.translation.x() += 1.0;
    for (const auto& d : survey_.detections) {
      // NadirSurvey writes the boxes object by object.
      const bool first = 2 * (&d - survey_.detections.data()) < static_cast<std::ptrdiff_t>(survey_.detections.size());
      const ObjectId object(first ? 1 : 2);
      truth_.detections.push_back({d.id, object, -1});
      truth_.boxes.push_back({d.frame, object, d.box, true, 1.0});
    }
    std::sort(truth_.boxes.begin(), truth_.boxes.end(),
              [](const auto& a, const auto& b) { return std::pair(a.frame, a.object) < std::pair(b.frame, b.object); });
    fs::create_directories(folder_ / "survey");
    io::write_survey(survey_, folder_ / "survey");
    io::write_truth(truth_, survey_.manifest.origin, folder_ / "survey");
    for (const auto& object : truth_.objects) {
      const Vec3 foot(object.cylinder.axis.x(), object.cylinder.axis.y(), 0.0);
      io::write_truth_mesh(folder_ / "survey", object.id,
                           cairn::testing::box(foot - Vec3(1, 1, 0), foot + Vec3(1, 1, 2)));
    }
  }

  // One target a rock, 1.03 m east of it.
  [[nodiscard]] io::TargetsFile targets() const {
    io::TargetsFile file;
    file.frame = survey_.manifest.origin;
    for (const auto& object : truth_.objects) {
      survey::Target t;
      t.id = survey::TargetId(object.id.value);
      t.object_class = object.object_class;
      t.state = survey::TargetState::converged;
      t.centre = object.cylinder.centre() + Vec3(1.03, 0, 0);
      t.covariance = geometry::Mat3::Identity() * 1e-4;
      for (const auto& origin : truth_.detections)
        if (origin.object == object.id) t.detections.push_back(origin.detection);
      const auto last = survey_.detection(t.detections.back())->frame;
      t.history = {{survey::TargetState::generated, last}, {survey::TargetState::converged, last}};
      t.bcylinder = object.cylinder;
      t.bcylinder->axis.x() += 1.0;
      t.bcylinder->radius *= 2.0;
      file.targets.push_back(t);
    }
    return file;
  }

  [[nodiscard]] static Json summary(const cairn::testing::ProgramResult& result) {
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return io::parse_json(result.out, "stdout");
  }
  [[nodiscard]] std::string path(const char* name) const { return (folder_ / name).string(); }

  TempFolder folder_;
  survey::Survey survey_;
  survey::Truth truth_;
};

TEST_F(EvaluateCommand, Targets) {
  fs::create_directories(folder_ / "out");
  io::write_targets(folder_ / "out/targets.json", targets());
  const auto s = summary(cairn(
      {"evaluate", "targets", path("out"), "--truth", path("survey/truth.json"), "--remove-bias", "survey", "--json"}));
  for (const char* stage : {"generated", "converged"}) {
    EXPECT_EQ(s.at("stages").at(stage).at("tp").as_integer(), 2);
    EXPECT_EQ(s.at("stages").at(stage).at("fp").as_integer(), 0);
    EXPECT_EQ(s.at("stages").at(stage).at("recall").as_real(), 1.0);
  }
  EXPECT_EQ(s.at("stages").at("mapped").at("fn").as_integer(), 2);
  EXPECT_TRUE(s.at("stages").at("mapped").at("precision").is_null());
  EXPECT_NEAR(s.at("mean_pose_bias_m").as_vec3().x(), 1.0, 1e-12);
  EXPECT_NEAR(s.at("centre_error_m").at("median").as_real(), 0.03, 1e-9);
  EXPECT_NEAR(s.at("nees").at("mean").as_real(), 9.0, 1e-6);
  EXPECT_NEAR(s.at("cylinder").at("iou").as_real(), 0.25, 1e-9);
  EXPECT_NEAR(s.at("cylinder").at("volume_ratio").as_real(), 4.0, 1e-9);
  EXPECT_EQ(s.at("cylinder").at("contained_share").as_real(), 1.0);
  EXPECT_EQ(s.at("refined").at("centre_error_m").at("count").as_integer(), 0);

  const auto raw = summary(cairn({"evaluate", "targets", path("out"), "--truth", path("survey"), "--json"}));
  EXPECT_NEAR(raw.at("centre_error_m").at("median").as_real(), 1.03, 1e-9);
  const auto text = cairn({"evaluate", "targets", path("out/targets.json"), "--truth", path("survey")});
  EXPECT_THAT(text.out, HasSubstr("converged  tp 2  fp 0  fn 0"));
}

TEST_F(EvaluateCommand, TargetsOfAnotherFrameAreRefused) {
  auto file = targets();
  file.frame.position.latitude_deg += 0.1;
  io::write_targets(folder_ / "targets.json", file);
  EXPECT_EQ(cairn({"evaluate", "targets", path("targets.json"), "--truth", path("survey")}).exit_code, 6);
}

TEST_F(EvaluateCommand, Detections) {
  const auto s = summary(
      cairn({"evaluate", "detections", path("survey/detections.csv"), "--truth", path("survey/truth.json"), "--json"}));
  EXPECT_NEAR(s.at("mean").at("ap50").as_real(), 1.0, 1e-12);
  EXPECT_NEAR(s.at("mean").at("ap50_95").as_real(), 1.0, 1e-12);
  EXPECT_NEAR(s.at("mean").at("ap50_90").as_real(), 1.0, 1e-12);
  EXPECT_EQ(s.at("classes").at("boulder").at("truths").as_integer(), 10);
  const auto folder = summary(cairn({"evaluate", "detections", path("survey"), "--truth", path("survey"), "--json"}));
  EXPECT_EQ(folder.at("tp").as_integer(), 10);
}

TEST_F(EvaluateCommand, DetectionsOfCocoFiles) {
  base::write_file(folder_ / "gt.json",
                   R"({"images":[{"id":7,"file_name":"a.jpg","width":100,"height":100}],
                       "categories":[{"id":3,"name":"rock"}],
                       "annotations":[{"id":1,"image_id":7,"category_id":3,"bbox":[10,10,20,20],"area":400,"iscrowd":0},
                                      {"id":2,"image_id":7,"category_id":3,"bbox":[60,10,20,20],"area":400,"iscrowd":0}]})");
  base::write_file(folder_ / "dt.json", R"([{"image_id":7,"category_id":3,"bbox":[10,10,20,20],"score":0.9},
                                            {"image_id":7,"category_id":3,"bbox":[10,60,20,20],"score":0.5}])");
  const auto s = summary(cairn({"evaluate", "detections", path("dt.json"), "--truth", path("gt.json"), "--json"}));
  // One of two found before the false one: precision 1 at the recalls 0 .. 0.50, none beyond.
  EXPECT_NEAR(s.at("classes").at("rock").at("ap50").as_real(), 51.0 / 101.0, 1e-12);
  EXPECT_EQ(s.at("fp").as_integer(), 1);
  EXPECT_EQ(s.at("fn").as_integer(), 1);
}

TEST_F(EvaluateCommand, TracksOfASurvey) {
  std::vector<survey::TrackedBox> rows;
  for (const auto& origin : truth_.detections) {
    survey::TrackedBox row;
    row.box = *survey_.detection(origin.detection);
    row.track = survey::TrackId(origin.object.value + 40);
    rows.push_back(row);
  }
  io::write_tracks(folder_ / "tracks.csv", rows);
  const auto s = summary(cairn({"evaluate", "tracks", path("tracks.csv"), "--truth", path("survey"), "--json"}));
  EXPECT_EQ(s.at("mota").as_real(), 1.0);
  EXPECT_EQ(s.at("idf1").as_real(), 1.0);
  EXPECT_NEAR(s.at("hota").as_real(), 1.0, 1e-12);
}

TEST_F(EvaluateCommand, TracksOfMotFiles) {
  // MOT17's columns: a pedestrian, a static person (class 7: ignored), one flagged 0, and a car.
  base::write_file(
      folder_ / "gt.txt",
      "1,1,10,10,20,40,1,1,1.0\n1,2,100,10,20,40,0,7,1.0\n1,3,200,10,20,40,0,1,1.0\n1,4,300,10,50,50,1,3,1\n"
      "2,1,12,10,20,40,1,1,1.0\n");
  base::write_file(folder_ / "out.txt",
                   "1,5,10,10,20,40,0.9,-1,-1,-1\n1,6,100,10,20,40,0.9,-1,-1,-1\n2,8,12,10,20,40,0.9,-1,-1,-1\n");
  const auto s = summary(cairn({"evaluate", "tracks", path("out.txt"), "--truth", path("gt.txt"), "--json"}));
  EXPECT_EQ(s.at("truth_boxes").as_integer(), 2);
  EXPECT_EQ(s.at("fp").as_integer(), 0);
  EXPECT_EQ(s.at("ignored_track_boxes").as_integer(), 1);
  EXPECT_EQ(s.at("id_switches").as_integer(), 1);
  EXPECT_EQ(s.at("mota").as_real(), 0.5);
  EXPECT_NEAR(s.at("idf1").as_real(), 0.5, 1e-12);

  fs::create_directories(folder_ / "results");
  fs::create_directories(folder_ / "truths/SEQ/gt");
  fs::copy(folder_ / "out.txt", folder_ / "results/SEQ.txt");
  fs::copy(folder_ / "gt.txt", folder_ / "truths/SEQ/gt/gt.txt");
  const auto all = summary(cairn({"evaluate", "tracks", path("results"), "--truth", path("truths"), "--json"}));
  EXPECT_EQ(all.at("sequences").at("SEQ").at("mota").as_real(), 0.5);
  EXPECT_EQ(all.at("mota").as_real(), 0.5);
}

TEST_F(EvaluateCommand, Trajectory) {
  const std::vector<std::string> base{"evaluate", "trajectory", path("survey"), "--truth", path("survey/truth.json"),
                                      "--json"};
  const auto with = [&](const char* align) {
    auto arguments = base;
    arguments.insert(arguments.end(), {"--align", align});
    return summary(cairn(arguments));
  };
  EXPECT_NEAR(with("none").at("ate").at("rmse_m").as_real(), 1.0, 1e-9);
  EXPECT_NEAR(with("translation").at("ate").at("rmse_m").as_real(), 0.0, 1e-9);
  EXPECT_NEAR(with("none").at("rpe").at("translation_m").at("rmse").as_real(), 0.0, 1e-9);
  EXPECT_EQ(with("none").at("match").as_string(), "id");
}

TEST_F(EvaluateCommand, WritesAFileWhereAsked) {
  const std::vector<std::string> arguments{
      "evaluate", "trajectory", path("survey"), "--truth", path("survey/truth.json"), "-o", path("score.json")};
  EXPECT_EQ(cairn(arguments).exit_code, 0);
  EXPECT_EQ(io::read_json(folder_ / "score.json").at("kind").as_string(), "trajectory");
  EXPECT_TRUE(fs::exists(folder_ / "score.json.run.json"));
  EXPECT_EQ(cairn(arguments).exit_code, 7);
}

TEST_F(EvaluateCommand, BadInput) {
  EXPECT_EQ(cairn({"evaluate", "targets", path("survey")}).exit_code, 2);
  EXPECT_EQ(cairn({"evaluate", "colours", path("survey"), "--truth", path("survey")}).exit_code, 2);
  EXPECT_EQ(cairn({"evaluate", "targets", path("none"), "--truth", path("survey")}).exit_code, 4);
  EXPECT_EQ(cairn({"evaluate", "targets", path("survey"), "--truth", path("survey")}).exit_code, 4);  // no targets.json
  EXPECT_EQ(cairn({"evaluate", "trajectory", path("survey"), "--truth", path("survey"), "--delta", "-1"}).exit_code, 2);
  base::write_file(folder_ / "gt.txt", "1,1,10,10,20,40,1,-1,-1,-1\n");
  base::write_file(folder_ / "det.txt", "1,-1,10,10,20,40,0.9,-1,-1,-1\n");
  const auto nameless = cairn({"evaluate", "tracks", path("det.txt"), "--truth", path("gt.txt")});
  EXPECT_EQ(nameless.exit_code, 4);
  EXPECT_THAT(nameless.err, HasSubstr("without identity"));
  base::write_file(folder_ / "twice.txt", "1,1,10,10,20,40,1,-1,-1,-1\n1,1,50,10,20,40,1,-1,-1,-1\n");
  const auto twice = cairn({"evaluate", "tracks", path("twice.txt"), "--truth", path("gt.txt")});
  EXPECT_EQ(twice.exit_code, 4);
  EXPECT_THAT(twice.err, HasSubstr("frame 1"));
  base::write_file(folder_ / "far.txt", "1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n");
  EXPECT_EQ(cairn({"evaluate", "trajectory", path("far.txt"), "--truth",
                   cairn::testing::test_data("tum/fr2_desk_groundtruth.txt").string()})
                .exit_code,
            4);
}

}  // namespace
