#include "localisation/tracker.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/angle.hpp"
#include "support/nadir_survey.hpp"

namespace cairn::localisation {
namespace {

using geometry::RigidTransform;
using geometry::Vec3;
using survey::TargetState;

RigidTransform turned(const Vec3& axis, double deg) {
  return {geometry::axis_rotation(axis, base::deg_to_rad(deg)), Vec3::Zero()};
}

TEST(Keyframe, ByDistance) {
  RigidTransform far;
  far.translation = {1.6, 0, 0};
  EXPECT_TRUE(is_keyframe(far, {}, Mode::paper, 1.5, 30.0));
  far.translation = {1.4, 0, 0};
  EXPECT_FALSE(is_keyframe(far, {}, Mode::robust, 1.5, 30.0));
}

TEST(Keyframe, YawInPaperWrapsAndIgnoresTheRest) {
  const Vec3 up = Vec3::UnitZ();
  EXPECT_TRUE(is_keyframe(turned(up, 31), {}, Mode::paper, 1.5, 30.0));
  EXPECT_FALSE(is_keyframe(turned(up, 29), {}, Mode::paper, 1.5, 30.0));
  // -170 and 170 deg are 20 deg apart (the public code says 340).
  EXPECT_FALSE(is_keyframe(turned(up, 170), turned(up, -170), Mode::paper, 1.5, 30.0));
  EXPECT_FALSE(is_keyframe(turned(Vec3::UnitX(), 40), {}, Mode::paper, 1.5, 30.0));
  EXPECT_TRUE(is_keyframe(turned(Vec3::UnitX(), 40), {}, Mode::robust, 1.5, 30.0));
}

class Tracked {
 public:
  Tracked(testing::NadirSurvey survey, LocateOptions options)
      : survey_(std::move(survey)),
        options_(resolved(std::move(options))),
        prepared_(prepare_boxes(survey_.survey, options_)),
        depth_(survey_.survey, prepared_, options_, nullptr),
        tracker_(prepared_, depth_, options_, ctx_) {
    for (std::size_t f = 0; f < prepared_.frames.size(); ++f) tracker_.step(f);
  }
  [[nodiscard]] const std::vector<LiveTarget>& targets() const { return tracker_.targets(); }

 private:
  testing::NadirSurvey survey_;
  LocateOptions options_;
  PreparedBoxes prepared_;
  base::RunContext ctx_;
  DepthPrior depth_;
  PointsTracker tracker_;
};

LocateOptions robust() {
  LocateOptions options;
  options.ground_up_m = 0.0;
  options.height_above_ground_m = 3.0;
  return options;
}

LocateOptions paper() {
  LocateOptions options;
  options.mode = "paper";
  options.max_depth_m = 42.0;
  return options;
}

TEST(PointsTracker, FollowsOneObject) {
  testing::NadirSurvey s(6, 4.0);
  s.object({10, 1, 0.5});
  const Tracked tracked(s, robust());
  ASSERT_EQ(tracked.targets().size(), 1U);
  const auto& target = tracked.targets()[0];
  EXPECT_EQ(target.boxes.size(), 6U);
  EXPECT_EQ(target.entropy_nats.size(), 6U);
  EXPECT_EQ(target.divergence.size(), 5U);
  EXPECT_EQ(target.state, TargetState::converging);
  EXPECT_LT((target.gaussian.mean - Vec3(10, 1, 0.5)).norm(), 0.4);  // m: the points spread over a 1 m box
  EXPECT_LT(target.entropy_nats.back(), target.entropy_nats.front());
}

TEST(PointsTracker, KeepsNeighboursApart) {
  testing::NadirSurvey s(5, 4.0);
  for (int i = 0; i < 4; ++i) s.object({6.0 + 2.5 * i, 0, 0.4});
  const Tracked tracked(s, robust());
  ASSERT_EQ(tracked.targets().size(), 4U);
  for (const auto& target : tracked.targets()) EXPECT_EQ(target.boxes.size(), 5U);
}

TEST(PointsTracker, DoesNotMixClasses) {
  testing::NadirSurvey s(2, 4.0);
  s.object({2, 0, 0}, 1.0, "boulder");
  s.survey.detections[1].object_class = "car";
  EXPECT_EQ(Tracked(s, robust()).targets().size(), 2U);
}

// One strike in paper: any iteration without its box counts.
TEST(PointsTracker, PaperDeregistersAfterMissedIterations) {
  testing::NadirSurvey s(12, 0.0);
  s.box(survey::FrameId(1), {400, 400, 450, 450}, "boulder");
  const Tracked tracked(s, paper());
  ASSERT_EQ(tracked.targets().size(), 1U);
  EXPECT_EQ(tracked.targets()[0].state, TargetState::deregistered);
  EXPECT_THAT(tracked.targets()[0].reasons, ::testing::Contains("missed"));
}

// Robust counts only frames that should show the target: here the flight goes on, away from it.
TEST(PointsTracker, RobustWaitsWhileTheTargetIsOutOfSight) {
  testing::NadirSurvey away(30, 20.0);
  away.box(survey::FrameId(1), {480, 480, 520, 520}, "boulder");
  EXPECT_NE(Tracked(away, robust()).targets()[0].state, TargetState::deregistered);
  testing::NadirSurvey hover(12, 0.0);
  hover.box(survey::FrameId(1), {480, 480, 520, 520}, "boulder");
  EXPECT_EQ(Tracked(hover, robust()).targets()[0].state, TargetState::deregistered);
}

// (A.5) below the threshold three times in a row, which takes a video's many keyframes.
TEST(PointsTracker, PaperConvergesOnManyKeyframes) {
  testing::NadirSurvey s(60, 2.0);
  s.object({60, 0, 0.5}, 2.0);
  auto options = paper();
  options.divergence_converged = 0.1;  // the letter's own noise of 0.1 m keeps D above 0.01 for 1000 points
  const Tracked tracked(s, options);
  ASSERT_FALSE(tracked.targets().empty());
  EXPECT_EQ(tracked.targets()[0].state, TargetState::converged);
}

TEST(PointsTracker, HoveringMakesNoKeyframes) {
  testing::NadirSurvey s(8, 0.1);
  s.object({0.4, 0, 0.5});
  const Tracked tracked(s, robust());
  ASSERT_EQ(tracked.targets().size(), 1U);
  EXPECT_EQ(tracked.targets()[0].boxes.size(), 8U);
  EXPECT_EQ(tracked.targets()[0].keyframes.size(), 1U);
}

}  // namespace
}  // namespace cairn::localisation
