// `cairn run`: recipes and surveys that cannot work. The whole job is in tests/end_to_end.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "base/atomic_file.hpp"
#include "io/json.hpp"
#include "io/survey_folder.hpp"
#include "support/data.hpp"
#include "support/run_program.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::testing::cairn;
using cairn::testing::TempFolder;
using ::testing::HasSubstr;

class RunCommand : public ::testing::Test {
 protected:
  TempFolder folder_;
  std::string recipe_ = (folder_ / "recipe.json").string(), survey_ = (folder_ / "survey").string(),
              out_ = (folder_ / "out").string();

  void SetUp() override {
    write_recipe(R"([{"stage": "locate"}])");
    cairn::survey::Survey survey;
    survey.manifest.name = "small";
    survey.manifest.origin = {{46.8426, -91.994, 158.0}, cairn::survey::HeightType::ellipsoidal, ""};
    cairn::survey::Camera camera;
    camera.id = cairn::survey::CameraId(1);
    camera.width_px = 1600;
    camera.height_px = 900;
    camera.fx_px = camera.fy_px = 900.0;
    camera.cx_px = 800.0;
    camera.cy_px = 450.0;
    survey.manifest.cameras = {camera};
    cairn::survey::Frame frame;
    frame.id = cairn::survey::FrameId(1);
    frame.camera = camera.id;
    frame.T_world_camera.translation = {0.0, 0.0, 40.0};
    survey.frames = {frame};
    fs::create_directory(survey_);
    cairn::io::write_survey(survey, survey_);
  }
  void write_recipe(const std::string& stages) const {
    cairn::base::write_file(recipe_, R"({"schema_version": 1, "name": "test", "stages": )" + stages + "}");
  }
  [[nodiscard]] cairn::testing::ProgramResult run(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments{"run", recipe_, survey_, "-o", out_};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return cairn(arguments);
  }
};

TEST_F(RunCommand, MistakesInTheRecipeAreNamed) {
  const std::pair<const char*, const char*> cases[] = {
      {R"([{"stage": "lokate"}])", "unknown stage"},
      {R"([{"stage": "surface"}])", "needs 'segment' before it"},
      {R"([{"stge": "locate"}])", "unknown member"},
      {R"([])", "no stages"},
      {R"([{"stage": "locate"}, {"stage": "locate"}])", "stands twice"},
      {R"([{"stage": "locate")", "not valid JSON"}};
  for (const auto& [stages, message] : cases) {
    write_recipe(stages);
    const auto result = run();
    EXPECT_EQ(result.exit_code, 4) << stages;
    EXPECT_THAT(result.err, HasSubstr(message));
    EXPECT_FALSE(fs::exists(out_));
  }
}

TEST_F(RunCommand, OptionsThatDoNotExistAreUsageErrors) {
  write_recipe(R"([{"stage": "locate", "options": {"no-such-option": 1}}])");
  const auto result = run({"--json"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(cairn::io::parse_json(result.out, "stdout").at("error").at("code").as_string(), "invalid_argument");
}

TEST_F(RunCommand, AMissingSurveyOrFileOfItIsNamed) {
  survey_ = (folder_ / "none").string();
  const auto none = run();
  EXPECT_EQ(none.exit_code, 4);
  EXPECT_THAT(none.err, HasSubstr("none"));

  survey_ = (folder_ / "survey").string();
  auto survey = cairn::io::read_survey(survey_);
  survey.frames[0].image = "gone.jpg";
  cairn::io::write_survey(survey, survey_);
  const auto image = run();
  EXPECT_EQ(image.exit_code, 4);
  EXPECT_THAT(image.err, HasSubstr("gone.jpg"));
  EXPECT_THAT(image.err, HasSubstr("frame 1"));
}

TEST_F(RunCommand, AStageThatNeedsACloudSaysSo) {
  write_recipe(R"([{"stage": "terrain"}])");
  const auto result = run();
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, HasSubstr("no point cloud"));
  EXPECT_THAT(result.err, HasSubstr("--cloud"));
  EXPECT_FALSE(fs::exists(fs::path(out_) / "surface.tif"));
}

TEST_F(RunCommand, AFolderOfOthersIsLeftAlone) {
  fs::create_directory(out_);
  cairn::base::write_file(fs::path(out_) / "thesis.txt", "years");
  EXPECT_EQ(run({"--overwrite"}).exit_code, 7);
  EXPECT_TRUE(fs::exists(fs::path(out_) / "thesis.txt"));
}

TEST_F(RunCommand, OutputThatCannotBeWritten) {
  out_ = "/proc/cairn/out";
  const auto result = run();
  EXPECT_EQ(result.exit_code, 5);
  EXPECT_THAT(result.err, HasSubstr("/proc/cairn"));
}

}  // namespace
