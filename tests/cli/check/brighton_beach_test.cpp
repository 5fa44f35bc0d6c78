// The traps of the real survey, told in samples/brighton_beach/README.md.
#include "check_run.hpp"
#include "support/data.hpp"

namespace {

using cairn::testing::check;
using cairn::testing::TempFolder;
using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

constexpr double kOffsetM = 0.1;  // how well the offset must be measured

TEST(CheckBrightonBeach, SoundWithItsSimilarity) {
  const TempFolder folder;
  cairn::testing::write_check_survey(cairn::testing::check_colmap_survey(true, true), folder / "survey");
  const auto run = check(folder / "survey");
  EXPECT_EQ(run.exit_code, 0) << run.json.dump();
  EXPECT_TRUE(run.ok());
  EXPECT_THAT(run.codes("error"), IsEmpty());
  // No vertical datum is declared anywhere, and that stays true.
  EXPECT_THAT(run.codes("warning"), ElementsAre("cloud_no_vertical_datum"));
  const auto& offset = run.json.at("evidence").at("cloud_offset");
  for (const char* axis : {"east_m", "north_m", "up_m"}) EXPECT_NEAR(offset.at(axis).as_real(), 0.0, kOffsetM) << axis;
  EXPECT_LT(run.json.at("evidence").at("tie_points_reprojection").at("median_px").as_real(), 1.0);
  const auto& height = run.json.at("evidence").at("height_above_ground");
  EXPECT_NEAR(height.at("median_m").as_real(), 37.0, 3.0);  // 40 m above the take-off point at the shore
  EXPECT_EQ(height.at("axis_hits_share").as_real(), 1.0);
}

// README: cloud minus colmap_enu is +0.57 m east, 0.00 m north, +0.92 m up.
TEST(CheckBrightonBeach, CloudBesideThePosesIsMeasured) {
  const TempFolder folder;
  cairn::testing::write_check_survey(cairn::testing::check_colmap_survey(true, false), folder / "survey");
  const auto run = check(folder / "survey");
  EXPECT_EQ(run.exit_code, 0);  // warnings alone
  EXPECT_TRUE(run.ok());
  const auto found = run.findings("cloud_offset");
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].at("severity").as_string(), "warning");
  EXPECT_THAT(found[0].at("hint").as_string(), HasSubstr("--similarity"));
  EXPECT_THAT(found[0].at("hint").as_string(), HasSubstr("refine"));
  EXPECT_THAT(found[0].at("file").as_string(), HasSubstr("model.las"));
  const auto& offset = run.json.at("evidence").at("cloud_offset");
  EXPECT_NEAR(offset.at("east_m").as_real(), 0.57, kOffsetM);
  EXPECT_NEAR(offset.at("north_m").as_real(), 0.0, kOffsetM);
  EXPECT_NEAR(offset.at("up_m").as_real(), 0.92, kOffsetM);
}

TEST(CheckBrightonBeach, SixTurnedFramesAndNoOthers) {
  const TempFolder folder;
  auto survey = cairn::testing::brighton_beach_exif();
  survey.manifest.origin.height_type = cairn::survey::HeightType::unknown;
  for (auto& frame : survey.frames)
    frame.image = cairn::testing::sample("brighton_beach/images_1600/" + frame.image).string();
  cairn::testing::write_check_survey(survey, folder / "survey");
  const auto run = check(folder / "survey");
  EXPECT_EQ(run.exit_code, 4);
  EXPECT_FALSE(run.ok());
  EXPECT_THAT(run.codes("error"), SizeIs(6)) << run.json.dump();
  const auto found = run.findings("frame_turned_180");
  ASSERT_THAT(found, SizeIs(6));
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_THAT(found[i].at("record").as_string(), HasSubstr("DJI_00" + std::to_string(24 + i)));
    EXPECT_EQ(found[i].at("hint").as_string(), "import again with --rotate DJI_0024-DJI_0029");
  }
}

TEST(CheckBrightonBeach, TextNamesTheVerdict) {
  const TempFolder folder;
  cairn::testing::write_check_survey(cairn::testing::check_small_survey(), folder / "survey");
  const auto result = cairn::testing::cairn({"check", (folder / "survey").string()});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, HasSubstr("is sound: 0 errors"));
  EXPECT_THAT(result.out, HasSubstr("median reprojection error of the tie points"));
}

}  // namespace
