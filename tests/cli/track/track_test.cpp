#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "io/json.hpp"
#include "io/survey_folder.hpp"
#include "io/tracks_csv.hpp"
#include "support/data.hpp"
#include "support/nadir_survey.hpp"
#include "support/run_program.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::base::read_file;
using cairn::base::write_file;
using cairn::testing::cairn;
using cairn::testing::TempFolder;
using ::testing::HasSubstr;

class TrackCommand : public ::testing::Test {
 protected:
  TempFolder folder_;
  fs::path out_ = folder_ / "out.txt";

  // Two objects that stand still for `frames` frames, in MOT rows.
  static std::string rows(int frames) {
    std::string text;
    for (int f = 1; f <= frames; ++f)
      for (int o = 0; o < 2; ++o)
        text += std::to_string(f) + ",-1," + std::to_string(100 + 300 * o) + ",50,40,60,0.5,-1,-1,-1\n";
    return text;
  }
  fs::path file(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_ / name).parent_path());
    write_file(folder_ / name, text);
    return folder_ / name;
  }
  [[nodiscard]] cairn::testing::ProgramResult run(const fs::path& in, std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments{"track", in.string(), "-o", out_.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return cairn(arguments);
  }
  static auto parsed(const cairn::testing::ProgramResult& result) {
    return cairn::io::parse_json(result.out, "stdout");
  }
};

TEST_F(TrackCommand, MotInMotOut) {
  const auto result =
      run(file("det.txt", rows(5)), {"--format", "mot", "--min-hits", "3", "--max-age", "1", "--iou", "0.3", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(parsed(result).at("tracks").as_integer(), 2);
  EXPECT_EQ(parsed(result).at("rows").as_integer(), 10);
  EXPECT_THAT(read_file(out_), ::testing::StartsWith("1,2,400.00,50.00,40.00,60.00,0.5,-1,-1,-1\n1,1,100.00,"));
  EXPECT_TRUE(fs::exists(folder_ / "out.txt.run.json"));
  EXPECT_EQ(run(file("det.txt", rows(5))).exit_code, 7);
}

TEST_F(TrackCommand, FormatIsRecognisedAndScoresCanBeLeftOut) {
  ASSERT_EQ(run(file("det.txt", rows(5)), {"--no-scores"}).exit_code, 0);
  EXPECT_THAT(read_file(out_), ::testing::StartsWith("1,2,400.00,50.00,40.00,60.00,1,-1,-1,-1\n"));
}

TEST_F(TrackCommand, SeveralFilesIntoAFolder) {
  file("A/det/det.txt", rows(4));
  file("B/det.txt", rows(6));
  file("c.txt", rows(3));
  const auto result = cairn({"track", folder_ / "A/det/det.txt", folder_ / "B/det.txt", folder_ / "c.txt", "-o",
                             folder_ / "results", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  for (const auto* name : {"A.txt", "B.txt", "c.txt", "run.json"})
    EXPECT_TRUE(fs::exists(folder_ / "results" / name)) << name;
  const auto files = parsed(result).at("files").as_array();
  ASSERT_EQ(files.size(), 3U);
  EXPECT_EQ(files[1].at("frames").as_integer(), 6);
  const auto clash = cairn({"track", folder_ / "c.txt", folder_ / "c.txt", "-o", folder_ / "twice"});
  EXPECT_EQ(clash.exit_code, 2);
  EXPECT_THAT(clash.err, HasSubstr("c.txt"));
}

TEST_F(TrackCommand, SameBytesForAnyThreadCount) {
  file("a.txt", rows(40));
  file("b.txt", rows(30));
  std::string text[2];
  for (const int threads : {1, 4}) {
    const fs::path out = folder_ / ("t" + std::to_string(threads));
    ASSERT_EQ(cairn({"track", folder_ / "a.txt", folder_ / "b.txt", "-o", out, "--threads", std::to_string(threads)})
                  .exit_code,
              0);
    text[threads / 4] = read_file(out / "a.txt") + read_file(out / "b.txt");
  }
  EXPECT_EQ(text[0], text[1]);
}

// Frames without boxes are frames: the track is lost in the gap, and starts anew.
TEST_F(TrackCommand, EmptyFramesAreStepped) {
  const auto gap = [](int frames) {
    return "1,-1,100,50,40,60,1\n2,-1,100,50,40,60,1\n" + std::to_string(3 + frames) + ",-1,100,50,40,60,1\n";
  };
  const auto one = run(file("det.txt", gap(1)), {"--min-hits", "0", "--json"});
  EXPECT_EQ(parsed(one).at("tracks").as_integer(), 1);
  const auto far = run(file("det.txt", gap(1'000'000'000)), {"--min-hits", "0", "--json", "--overwrite"});
  EXPECT_EQ(parsed(far).at("tracks").as_integer(), 2);
  EXPECT_EQ(parsed(far).at("frames").as_integer(), 1'000'000'003);
}

TEST_F(TrackCommand, FramesMayCountFromZero) {
  const auto result = run(file("det.txt", "0,-1,100,50,40,60,1\n1,-1,100,50,40,60,1\n"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(read_file(out_), ::testing::StartsWith("0,1,100.00,"));
}

TEST_F(TrackCommand, BadBoxesAreLeftOutWithTheirReason) {
  const auto result = run(file("det.txt", rows(5) + "3,-1,100,50,40,60,0.5\n"
                                                    "3,-1,100,50,0,60,0.5\n"
                                                    "3,-1,100,50,-4,60,0.5\n"
                                                    "3,-1,nan,50,4,60,0.5\n"
                                                    "3,-1,1,50,inf,60,0.5\n"
                                                    "-2,-1,1,50,4,60,0.5\n"),
                          {"--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto reasons = parsed(result).at("rejects_by_reason");
  EXPECT_EQ(reasons.at("duplicate_box").as_integer(), 1);
  EXPECT_EQ(reasons.at("zero_area_box").as_integer(), 1);
  EXPECT_EQ(reasons.at("negative_size_box").as_integer(), 1);
  EXPECT_EQ(reasons.at("non_finite_box").as_integer(), 2);
  EXPECT_EQ(reasons.at("frame_out_of_range").as_integer(), 1);
  EXPECT_EQ(parsed(result).at("notices_by_reason").at("unsorted_frames").as_integer(), 1);
  EXPECT_THAT(read_file(out_), ::testing::Not(HasSubstr("nan")));
  EXPECT_THAT(read_file(out_), ::testing::Not(HasSubstr("inf")));
  EXPECT_THAT(read_file(out_.string() + ".run.json"), HasSubstr("zero_area_box"));
  // The same boxes without the bad ones give the same tracks.
  const std::string with_bad = read_file(out_);
  ASSERT_EQ(run(file("good.txt", rows(5)), {"--overwrite"}).exit_code, 0);
  EXPECT_EQ(read_file(out_), with_bad);
}

TEST_F(TrackCommand, BadInput) {
  EXPECT_EQ(run(folder_ / "none.txt").exit_code, 4);
  EXPECT_EQ(run(file("det.txt", "hello\n")).exit_code, 4);
  const auto word = run(file("det.txt", "1,-1,2,3,4,five,1\n"));
  EXPECT_EQ(word.exit_code, 4);
  EXPECT_THAT(word.err, ::testing::AllOf(HasSubstr("det.txt"), HasSubstr("line 1"), HasSubstr("'five'")));
  EXPECT_EQ(run(file("det.txt", rows(3)), {"--iou", "1.5"}).exit_code, 2);
  EXPECT_EQ(run(file("det.txt", rows(3)), {"--emit-age", "4"}).exit_code, 2);
  EXPECT_EQ(run(file("det.txt", rows(3)), {"--format", "tfrecord"}).exit_code, 2);
  EXPECT_EQ(cairn({"track", "-o", out_.string()}).exit_code, 2);
  EXPECT_FALSE(fs::exists(out_));
  const auto empty = run(file("empty.txt", ""), {"--json"});
  EXPECT_EQ(empty.exit_code, 0) << empty.err;
  EXPECT_EQ(parsed(empty).at("tracks").as_integer(), 0);
}

TEST_F(TrackCommand, OtherFormatsAreTracked) {
  std::string text = "[";
  for (int f = 1; f <= 5; ++f)
    text += std::string(f > 1 ? "," : "") + R"({"image_id": )" + std::to_string(10 * f) +
            R"(, "category_id": 1, "bbox": [100, 50, 40, 60], "score": 0.5})";
  const auto result = run(file("results.json", text + "]"), {"--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(parsed(result).at("tracks").as_integer(), 1);
  EXPECT_THAT(read_file(out_), HasSubstr("5,1,100.00,50.00,40.00,60.00,0.5,"));
}

class TrackSurvey : public TrackCommand {
 protected:
  cairn::testing::NadirSurvey made_{12, 0.2};
  void SetUp() override {
    out_ = folder_ / "tracks.csv";
    made_.object({1, 0, 0.5}, 2.0);
    made_.object({1, 4, 0.5}, 2.0, "tree");
    made_.survey.manifest.name = "made up";
    made_.survey.manifest.origin.position = {46.8426, -91.994, 158.0};
    made_.survey.manifest.origin.height_type = cairn::survey::HeightType::ellipsoidal;
  }
  void write() const {
    fs::create_directories(folder_ / "survey");
    cairn::io::write_survey(made_.survey, folder_ / "survey");
  }
};

TEST_F(TrackSurvey, WritesTracksThatNameTheirDetections) {
  write();
  const auto result = run(folder_ / "survey", {"--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(parsed(result).at("tracks").as_integer(), 2);
  const auto rows = cairn::io::read_tracks(out_, made_.survey);
  ASSERT_EQ(rows.size(), made_.survey.detections.size());
  for (const auto& row : rows) EXPECT_EQ(row.box, *made_.survey.detection(row.box.id));
  ASSERT_EQ(run(folder_ / "survey", {"--boxes", "filtered", "--overwrite"}).exit_code, 0);
  EXPECT_NE(cairn::io::read_tracks(out_, made_.survey).back().box.box, rows.back().box.box);
}

TEST_F(TrackSurvey, CoastedRowsCarryNoDetection) {
  std::erase_if(made_.survey.detections, [](const auto& d) { return d.frame.value == 8 || d.frame.value == 9; });
  write();
  const auto result = run(folder_ / "survey", {"--max-age", "5", "--emit-age", "5", "--streak", "keep", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(parsed(result).at("coasted_rows").as_integer(), 4);
  int coasted = 0;
  for (const auto& row : cairn::io::read_tracks(out_, made_.survey)) {
    if (row.state != cairn::survey::TrackState::coasted) continue;
    ++coasted;
    EXPECT_FALSE(row.box.id.valid());
    EXPECT_TRUE(row.box.frame.value == 8 || row.box.frame.value == 9);
  }
  EXPECT_EQ(coasted, 4);
}

TEST_F(TrackSurvey, ClockJumpsAndUnsortedFramesAreNoticed) {
  for (std::size_t i = 0; i < made_.survey.frames.size(); ++i)
    made_.survey.frames[i].time_ns = 1'000'000'000'000 + static_cast<std::int64_t>(i) * 100'000'000;
  std::swap(made_.survey.frames[2].time_ns, made_.survey.frames[3].time_ns);
  for (std::size_t i = 6; i < made_.survey.frames.size(); ++i) made_.survey.frames[i].time_ns -= 999'000'000'000;
  write();
  const auto result = run(folder_ / "survey", {"--json", "--real-time"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto notices = parsed(result).at("notices_by_reason");
  EXPECT_EQ(notices.at("clock_jump").as_integer(), 1);
  EXPECT_EQ(notices.at("unsorted_frames").as_integer(), 1);
  // No identity reaches across the jump.
  EXPECT_EQ(parsed(result).at("tracks").as_integer(), 4);
}

TEST_F(TrackSurvey, WithoutDetectionsThereIsNothingToTrack) {
  made_.survey.detections.clear();
  write();
  const auto result = run(folder_ / "survey");
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, HasSubstr("no detections"));
}

}  // namespace
