#include "localisation/boxes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/nadir_survey.hpp"

namespace cairn::localisation {
namespace {

using survey::FrameId;

std::vector<std::string> reasons(const PreparedBoxes& prepared) {
  std::vector<std::string> result;
  for (const auto& reject : prepared.rejects) result.push_back(reject.reason);
  return result;
}

TEST(PrepareBoxes, NamesWhatItRejects) {
  testing::NadirSurvey s(2);
  s.box(FrameId(1), {400, 400, 450, 450}, "boulder");
  s.box(FrameId(9), {400, 400, 450, 450}, "boulder");
  s.box(FrameId(1), {500, 400, 500, 450}, "boulder");
  s.box(FrameId(1), {500, 450, 550, 450}, "boulder");
  s.box(FrameId(1), {600, 400, 550, 450}, "boulder");
  s.box(FrameId(1), {std::nan(""), 400, 450, 450}, "boulder");
  s.box(FrameId(1), {400, 400, std::numeric_limits<double>::infinity(), 450}, "boulder");
  s.box(FrameId(2), {400, 400, 450, 450}, "boulder").score = 0.1;
  LocateOptions options;
  options.min_score = 0.5;
  const auto prepared = prepare_boxes(s.survey, options);
  EXPECT_EQ(prepared.boxes.size(), 1U);
  EXPECT_THAT(reasons(prepared),
              ::testing::ElementsAre("unknown_frame", "zero_area_box", "zero_area_box", "zero_area_box",
                                     "non_finite_box", "non_finite_box", "low_score"));
  EXPECT_EQ(prepared.rejects[0].record, "detection 2");
}

TEST(PrepareBoxes, DropsTheWeakerOfTwoEqualBoxes) {
  testing::NadirSurvey s(1);
  s.box(FrameId(1), {400, 400, 450, 450}, "boulder").score = 0.5;
  s.box(FrameId(1), {400, 400, 450, 450}, "boulder").score = 0.7;
  s.box(FrameId(1), {401, 400, 451, 450}, "boulder").score = 0.7;
  s.box(FrameId(1), {400, 400, 450, 450}, "car");
  const auto prepared = prepare_boxes(s.survey, {});
  ASSERT_EQ(prepared.boxes.size(), 2U);
  EXPECT_EQ(prepared.boxes[0].id.value, 2);
  EXPECT_EQ(prepared.boxes[1].id.value, 4);
  EXPECT_THAT(reasons(prepared), ::testing::ElementsAre("duplicate_box", "duplicate_box"));
}

TEST(PrepareBoxes, AtTheEdge) {
  testing::NadirSurvey s(1);
  s.box(FrameId(1), {4, 400, 54, 480}, "boulder");
  s.box(FrameId(1), {6, 500, 56, 550}, "boulder");
  LocateOptions options;
  options.mode = "paper";
  EXPECT_THAT(reasons(prepare_boxes(s.survey, options)), ::testing::ElementsAre("edge"));
  const auto robust = prepare_boxes(s.survey, {});
  EXPECT_TRUE(robust.rejects.empty());
  ASSERT_EQ(robust.frames[0].cut_boxes.size(), 1U);
  const Box& cut = robust.boxes[robust.frames[0].cut_boxes[0]];
  EXPECT_TRUE(cut.cut);
  EXPECT_GT(cut.sigma_px.x(), 40.0);  // half the longer side, across the border it touches
  EXPECT_LT(cut.sigma_px.y(), 10.0);
}

TEST(PrepareBoxes, FramesComeByTimeThenId) {
  testing::NadirSurvey s(3);
  s.survey.frames[0].time_ns = 30;
  s.survey.frames[1].time_ns = 10;
  s.survey.frames[2].time_ns = 10;
  const auto prepared = prepare_boxes(s.survey, {});
  EXPECT_EQ(prepared.frames[0].id, FrameId(2));
  EXPECT_EQ(prepared.frames[1].id, FrameId(3));
  EXPECT_EQ(prepared.frames[2].id, FrameId(1));
}

TEST(PrepareBoxes, UnusableFramesAreNamed) {
  testing::NadirSurvey s(2);
  s.survey.frames[0].camera = survey::CameraId(7);
  s.survey.frames[1].T_world_camera.translation.x() = std::nan("");
  s.box(FrameId(1), {400, 400, 450, 450}, "boulder");
  s.box(FrameId(2), {400, 400, 450, 450}, "boulder");
  const auto prepared = prepare_boxes(s.survey, {});
  EXPECT_TRUE(prepared.frames.empty());
  EXPECT_THAT(reasons(prepared), ::testing::ElementsAre("unknown_camera", "bad_pose", "unknown_camera", "bad_pose"));
}

TEST(PrepareBoxes, TakesDistortionOut) {
  testing::NadirSurvey s(1);
  auto& camera = s.survey.manifest.cameras[0];
  camera.model = survey::CameraModel::radial;
  camera.k1 = -0.1;
  s.box(FrameId(1), {800, 480, 840, 520}, "boulder");
  const auto prepared = prepare_boxes(s.survey, {});
  ASSERT_EQ(prepared.boxes.size(), 1U);
  // Barrel distortion: x_d = x (1 - 0.1 x^2) = 0.32 at x = 0.32338 on the axis.
  EXPECT_NEAR(prepared.boxes[0].centre_px.x(), 500.0 + 1000.0 * 0.323391, 0.05);
  EXPECT_NEAR(prepared.boxes[0].centre_px.y(), 500.0, 1e-6);
}

}  // namespace
}  // namespace cairn::localisation
