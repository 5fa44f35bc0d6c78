#include "adjustment/evidence_ties.hpp"

#include <gmock/gmock.h>

#include "adjustment/pose_hypotheses.hpp"
#include "support/simulated_survey.hpp"

namespace cairn::adjustment {
namespace {

using geometry::Mat3;
using geometry::RigidTransform;
using geometry::Vec2;
using survey::Survey;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kNoiseMedianPx = 0.36;  // median of a Rayleigh distribution: 1.177 * 0.3 px
constexpr double kNoiseTolerancePx = 0.05;

template <typename Change>
Survey with_poses(Change change, const testing::SimulatedOptions& options = {}) {
  auto survey = testing::simulated_survey(options);
  for (auto& frame : survey.frames) frame.T_world_camera = change(frame.T_world_camera);
  return survey;
}

// The one verdict names all frames, and explains them down to the noise.
void expect_explained(const Survey& survey, const std::string& code) {
  const auto evidence = tie_evidence(survey);
  EXPECT_GT(evidence.median_px, 5.0);
  ASSERT_THAT(evidence.verdicts, SizeIs(1)) << code;
  EXPECT_EQ(evidence.verdicts[0].code, code);
  EXPECT_THAT(evidence.verdicts[0].frames, SizeIs(survey.frames.size()));
  EXPECT_GT(evidence.verdicts[0].before_px, 5.0);
  EXPECT_NEAR(evidence.verdicts[0].after_px, kNoiseMedianPx, kNoiseTolerancePx);
  EXPECT_FALSE(evidence.verdicts[0].remedy.empty());
  EXPECT_THAT(evidence.unexplained, IsEmpty());
}

TEST(TieEvidence, SoundSurveyHasNoVerdict) {
  const auto survey = testing::simulated_survey();
  const auto evidence = tie_evidence(survey);
  EXPECT_THAT(evidence.verdicts, IsEmpty());
  EXPECT_THAT(evidence.unexplained, IsEmpty());
  EXPECT_NEAR(evidence.median_px, kNoiseMedianPx, kNoiseTolerancePx);
  EXPECT_EQ(evidence.points, survey.ties.size());
  ASSERT_THAT(evidence.frames, SizeIs(survey.frames.size()));
  for (const auto& frame : evidence.frames) EXPECT_EQ(frame.behind, 0U);
}

TEST(TieEvidence, NamesWorldToCameraPoses) {
  expect_explained(with_poses([](const RigidTransform& T) { return T.inverse(); }), "pose_inverted");
}

TEST(TieEvidence, NamesConjugatedQuaternions) {
  // The rotation of a camera that looks straight down is symmetric: only tilted frames show the mistake.
  testing::SimulatedOptions options;
  options.tilt_deg = 10.0;
  expect_explained(with_poses(
                       [](const RigidTransform& T) {
                         return RigidTransform{T.rotation.transpose(), T.translation};
                       },
                       options),
                   "quaternion_conjugated");
}

TEST(TieEvidence, NamesTranslationsTakenForCentres) {
  expect_explained(with_poses([](const RigidTransform& T) {
                     return RigidTransform{T.rotation, T.inverse().translation};
                   }),
                   "position_is_translation");
}

TEST(TieEvidence, NamesQuaternionsReadInTheWrongOrder) {
  // Stored x,y,z,w; the reader took the first for w.
  expect_explained(with_poses([](const RigidTransform& T) {
                     const auto q = geometry::quaternion(T.rotation);
                     return RigidTransform{geometry::rotation_matrix({q.qx, q.qy, q.qz, q.qw}), T.translation};
                   }),
                   "quaternion_order_xyzw");
  // Stored w,x,y,z; the reader took the last for w.
  expect_explained(with_poses([](const RigidTransform& T) {
                     const auto q = geometry::quaternion(T.rotation);
                     return RigidTransform{geometry::rotation_matrix({q.qz, q.qw, q.qx, q.qy}), T.translation};
                   }),
                   "quaternion_order_wxyz");
}

TEST(TieEvidence, NamesOpenGlCameraAxes) {
  expect_explained(with_poses([](const RigidTransform& T) {
                     Mat3 flip = Mat3::Identity();
                     flip.diagonal() << 1, -1, -1;
                     return RigidTransform{T.rotation * flip, T.translation};
                   }),
                   "camera_axes_opengl");
}

TEST(TieEvidence, NamesNorthEastDownWorld) {
  expect_explained(with_poses([](const RigidTransform& T) {
                     Mat3 ned;
                     ned << 0, 1, 0, 1, 0, 0, 0, 0, -1;
                     return RigidTransform{ned * T.rotation, ned * T.translation};
                   }),
                   "world_axes_ned");
}

TEST(TieEvidence, NamesTwoMistakesAtOnce) {
  expect_explained(with_poses([](const RigidTransform& T) {
                     const auto inverse = T.inverse();
                     const auto q = geometry::quaternion(inverse.rotation);
                     return RigidTransform{geometry::rotation_matrix({q.qx, q.qy, q.qz, q.qw}), inverse.translation};
                   }),
                   "quaternion_order_xyzw+pose_inverted");
}

TEST(TieEvidence, NamesTheTurnedFramesOnly) {
  auto survey = testing::simulated_survey();
  const auto& camera = survey.manifest.cameras.front();
  const Vec2 far(static_cast<double>(camera.width_px), static_cast<double>(camera.height_px));
  for (auto& tie : survey.ties)
    for (auto& observation : tie.observations)
      if (observation.frame.value >= 5 && observation.frame.value <= 8) observation.pixel = far - observation.pixel;
  const auto evidence = tie_evidence(survey);
  ASSERT_THAT(evidence.verdicts, SizeIs(1));
  EXPECT_EQ(evidence.verdicts[0].code, "frame_turned_180");
  EXPECT_THAT(evidence.verdicts[0].frames,
              ::testing::ElementsAre(survey::FrameId(5), survey::FrameId(6), survey::FrameId(7), survey::FrameId(8)));
  EXPECT_NEAR(evidence.verdicts[0].after_px, kNoiseMedianPx, kNoiseTolerancePx);
}

TEST(TieEvidence, NamesQuarterTurns) {
  // Turned clockwise: what was at (x, y) comes to (height - y, x); counter-clockwise: to (y, width - x).
  for (const bool clockwise : {true, false}) {
    auto survey = testing::simulated_survey();
    const auto& camera = survey.manifest.cameras.front();
    const double width = static_cast<double>(camera.width_px), height = static_cast<double>(camera.height_px);
    for (auto& tie : survey.ties)
      for (auto& observation : tie.observations) {
        const auto p = observation.pixel;
        observation.pixel = clockwise ? Vec2(height - p.y(), p.x()) : Vec2(p.y(), width - p.x());
      }
    expect_explained(survey, clockwise ? "frame_turned_90" : "frame_turned_270");
  }
}

TEST(TieEvidence, NamesImagesOfAnotherSize) {
  auto survey = testing::simulated_survey();
  for (auto& tie : survey.ties)
    for (auto& observation : tie.observations) observation.pixel *= 2.5;
  const auto evidence = tie_evidence(survey);
  ASSERT_THAT(evidence.verdicts, SizeIs(1));
  EXPECT_EQ(evidence.verdicts[0].code, "image_scale");
  constexpr double kScaleTolerance = 0.002;  // of 2.5: from 0.3 px noise over half an image
  EXPECT_NEAR(evidence.verdicts[0].scale, 2.5, kScaleTolerance);
}

TEST(TieEvidence, NamesHalfAPixel) {
  for (const double sign : {-1.0, 1.0}) {
    auto survey = testing::simulated_survey();
    for (auto& tie : survey.ties)
      for (auto& observation : tie.observations) observation.pixel += Vec2::Constant(0.5 * sign);
    const auto evidence = tie_evidence(survey);
    ASSERT_THAT(evidence.verdicts, SizeIs(1));
    EXPECT_EQ(evidence.verdicts[0].code, "half_pixel_shift");
    EXPECT_GT(evidence.verdicts[0].before_px, evidence.verdicts[0].after_px);
    EXPECT_NEAR(evidence.verdicts[0].after_px, kNoiseMedianPx, kNoiseTolerancePx);
  }
}

TEST(TieEvidence, DoesNotExplainNonsense) {
  auto survey = testing::simulated_survey();
  survey.frames[2].T_world_camera.translation.x() += 30.0;
  const auto evidence = tie_evidence(survey);
  EXPECT_THAT(evidence.verdicts, IsEmpty());
  EXPECT_THAT(evidence.unexplained, ::testing::ElementsAre(survey.frames[2].id));
}

TEST(TieEvidence, IgnoresNonFiniteAndUnknown) {
  auto survey = testing::simulated_survey();
  survey.ties[0].p_world.x() = std::nan("");
  survey.ties[1].observations[0].pixel.y() = std::nan("");
  survey.ties[2].observations[0].frame = survey::FrameId(999);
  survey.frames[1].T_world_camera.translation.z() = std::nan("");
  const auto evidence = tie_evidence(survey);
  EXPECT_THAT(evidence.verdicts, IsEmpty());
  EXPECT_TRUE(std::isfinite(evidence.median_px));
  EXPECT_THAT(evidence.frames, SizeIs(survey.frames.size() - 1));
}

TEST(PoseHypotheses, DeclaredComesFirstAndEachHasItsOwnCode) {
  const auto& all = pose_hypotheses();
  ASSERT_FALSE(all.empty());
  EXPECT_EQ(all.front().code(), "as_declared");
  std::vector<std::string> codes;
  for (const auto& hypothesis : all) codes.push_back(hypothesis.code());
  std::sort(codes.begin(), codes.end());
  EXPECT_EQ(std::adjacent_find(codes.begin(), codes.end()), codes.end());
}

}  // namespace
}  // namespace cairn::adjustment
