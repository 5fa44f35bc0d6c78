#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "base/atomic_file.hpp"
#include "io/json.hpp"
#include "io/survey_folder.hpp"
#include "support/data.hpp"
#include "support/drawn_face.hpp"
#include "support/nadir_survey.hpp"
#include "support/onnx_bytes.hpp"
#include "support/run_program.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::testing::cairn;
using ::testing::HasSubstr;

class DetectCommand : public ::testing::Test {
 protected:
  cairn::testing::TempFolder folder_;
  cairn::testing::NadirSurvey made_{3};
  fs::path survey_ = folder_ / "survey", out_ = folder_ / "detections.csv";
  std::string model_ = cairn::testing::test_data("detectors/yunet_n_320_320.onnx").string();

  void SetUp() override {
    fs::create_directories(survey_);
    for (std::size_t i = 0; i < 3; ++i) {
      cv::Mat image = cairn::testing::grey_background(400, 300);
      if (i != 1) cairn::testing::draw_face(image, 150 + 50 * static_cast<int>(i), 150, 120);
      const std::string name = "image" + std::to_string(i) + ".png";
      cv::imwrite((survey_ / name).string(), image);
      made_.survey.frames[i].image = name;
    }
    made_.survey.manifest.name = "faces";
    made_.survey.manifest.origin.position = {46.8426, -91.994, 158.0};
    made_.survey.manifest.origin.height_type = cairn::survey::HeightType::ellipsoidal;
    write();
  }
  void write() const { cairn::io::write_survey(made_.survey, survey_); }
  [[nodiscard]] cairn::testing::ProgramResult run(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments{"detect", survey_.string(), "--model",     model_,
                                       "-o",     out_.string(),    "--min-score", "0.7"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return cairn(arguments);
  }
};

TEST_F(DetectCommand, WritesDetectionsThatTheSurveyReads) {
  const auto result = run({"--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = cairn::io::parse_json(result.out, "stdout");
  EXPECT_EQ(summary.at("detections").as_integer(), 2);
  EXPECT_EQ(summary.at("detections_by_class").at("face").as_integer(), 2);
  EXPECT_EQ(summary.at("decoder").as_string(), "yunet");
  EXPECT_TRUE(fs::exists(out_.string() + ".run.json"));
  fs::copy_file(out_, survey_ / "detections.csv");
  const auto read = cairn::io::read_survey(survey_);
  ASSERT_EQ(read.detections.size(), 2U);
  EXPECT_EQ(read.detections[0].frame.value, 1);
  EXPECT_EQ(read.detections[1].frame.value, 3);
  EXPECT_NEAR(read.detections[1].box.centre().x(), 250.0, 10.0);
}

TEST_F(DetectCommand, SameBytesForAnyThreadCount) {
  ASSERT_EQ(run({"--threads", "1"}).exit_code, 0);
  const std::string one = cairn::base::read_file(out_);
  ASSERT_EQ(run({"--threads", "4", "--overwrite"}).exit_code, 0);
  EXPECT_EQ(cairn::base::read_file(out_), one);
}

TEST_F(DetectCommand, ClassNamesFromAFile) {
  cairn::base::write_file(folder_ / "names.txt", "boulder\n");
  ASSERT_EQ(run({"--names", (folder_ / "names.txt").string()}).exit_code, 0);
  EXPECT_THAT(cairn::base::read_file(out_), HasSubstr(",boulder,"));
}

TEST_F(DetectCommand, ImagesThatCannotBeReadAreNamedAndTheRestIsDone) {
  made_.survey.frames[0].image = "gone.png";
  made_.survey.frames[1].image = "";
  write();
  const auto result = run({"--json"});
  EXPECT_EQ(result.exit_code, 3) << result.err;
  const auto summary = cairn::io::parse_json(result.out, "stdout");
  EXPECT_EQ(summary.at("rejects_by_reason").at("unreadable_image").as_integer(), 1);
  EXPECT_EQ(summary.at("rejects_by_reason").at("no_image").as_integer(), 1);
  EXPECT_EQ(summary.at("detections").as_integer(), 1);
  made_.survey.frames[2].image = "gone too.png";
  write();
  EXPECT_EQ(run({"--overwrite"}).exit_code, 4);
}

TEST_F(DetectCommand, AModelThatCannotBeUsed) {
  model_ = (folder_ / "m.onnx").string();
  const auto bad = [&](const std::string& bytes, const std::string& says) {
    cairn::base::write_file(model_, bytes);
    const auto result = run();
    EXPECT_EQ(result.exit_code, 4) << says;
    EXPECT_THAT(result.err, ::testing::AllOf(HasSubstr("m.onnx"), HasSubstr(says)));
    EXPECT_FALSE(fs::exists(out_));
  };
  bad(cairn::testing::onnx_model("FancyAttention", {1, 3, 32, 32}), "Export it again");
  bad(cairn::testing::onnx_model("Relu", {1, 3, 32, 32}), "result 1x3x32x32");
  bad("text", "not an ONNX model");
  fs::remove(model_);
  EXPECT_EQ(run().exit_code, 4);
}

TEST_F(DetectCommand, Usage) {
  EXPECT_EQ(cairn({"detect", survey_.string(), "-o", out_.string()}).exit_code, 2);
  EXPECT_EQ(run({"--decoder", "fancy"}).exit_code, 2);
  EXPECT_EQ(run({"--overlap", "1"}).exit_code, 2);
  EXPECT_EQ(run({"--dry-run"}).exit_code, 0);
  EXPECT_FALSE(fs::exists(out_));
}

}  // namespace
