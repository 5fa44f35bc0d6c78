#include "evaluation/target_errors.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cairn::evaluation {
namespace {

using geometry::Mat3;
using geometry::Vec2;
using geometry::Vec3;
using survey::DetectionId;
using survey::FrameId;
using survey::ObjectId;
using survey::TargetId;
using survey::TargetState;

// Two rocks of radius 1 and height 2 at (10 k, 0, 5); rock k is boxed in frames 10 k .. 10 k + 2. The recorded
// positions are off by (1, 2, -1) in frames below 20 and by (3, 2, -1) from there.
class Errors : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const int k : {1, 2}) {
      survey::TruthObject object;
      object.id = ObjectId(k);
      object.sought = true;
      object.cylinder = {Vec2(10.0 * k, 0), 4.0, 6.0, 1.0};
      truth_.objects.push_back(object);
      survey::Target target;
      target.id = TargetId(k);
      target.state = TargetState::converged;
      for (int f = 10 * k; f < 10 * k + 3; ++f) {
        survey::Frame frame;
        frame.id = FrameId(f);
        frame.T_world_camera.translation = Vec3(f, 0, 20);
        truth_.frames.push_back(frame);
        frame.T_world_camera.translation += Vec3(f < 20 ? 1 : 3, 2, -1);
        recorded_.push_back(frame);
        survey::Detection d;
        d.id = DetectionId(f);
        d.frame = FrameId(f);
        detections_.push_back(d);
        truth_.detections.push_back({d.id, ObjectId(k), -1});
        target.detections.push_back(d.id);
      }
      target.centre = object.cylinder.centre() + Vec3(k == 1 ? 1 : 3, 2, -1) + Vec3(0.03, 0.04, 0.12);
      target.covariance = Vec3(0.01, 0.01, 0.04).asDiagonal();
      target.history = {{TargetState::generated, FrameId(10 * k)}, {TargetState::converged, FrameId(10 * k + 2)}};
      targets_.push_back(target);
    }
  }
  [[nodiscard]] TargetErrors score(BiasRemoval bias) const {
    const auto stages = score_stages(targets_, detections_, truth_, {});
    return score_errors(targets_, stages, detections_, recorded_, truth_, {}, bias);
  }
  survey::Truth truth_;
  std::vector<survey::Frame> recorded_;
  std::vector<survey::Detection> detections_;
  std::vector<survey::Target> targets_;
};

constexpr double kExact = 1e-12;  // m

TEST_F(Errors, BiasOfTheFlightAndOfTheTarget) {
  const auto survey = score(BiasRemoval::survey);
  EXPECT_NEAR((survey.survey_bias - Vec3(2, 2, -1)).norm(), 0.0, kExact);
  ASSERT_EQ(survey.filter.centres.size(), 2U);
  EXPECT_NEAR((survey.filter.centres[0].error - Vec3(-0.97, 0.04, 0.12)).norm(), 0.0, kExact);
  EXPECT_NEAR((survey.filter.centres[1].error - Vec3(1.03, 0.04, 0.12)).norm(), 0.0, kExact);

  const auto own = score(BiasRemoval::target);
  EXPECT_NEAR(own.filter.centre().median, 0.13, kExact);
  EXPECT_NEAR(own.filter.horizontal().p95, 0.05, kExact);
  EXPECT_NEAR(own.filter.vertical().max, 0.12, kExact);
  // 0.03^2 / 0.01 + 0.04^2 / 0.01 + 0.12^2 / 0.04
  EXPECT_NEAR(own.filter.nees()[0], 0.09 + 0.16 + 0.36, 1e-9);
  EXPECT_TRUE(own.refined.centres.empty());

  const auto raw = score(BiasRemoval::none);
  EXPECT_NEAR((raw.filter.centres[0].error - Vec3(1.03, 2.04, -0.88)).norm(), 0.0, kExact);
}

TEST_F(Errors, RefinedBodiesAndCylinders) {
  survey::RefinedBody body;
  body.centre = truth_.objects[0].cylinder.centre() + Vec3(1, 2, -1);
  body.covariance = Mat3::Identity();
  body.cylinder = {Vec2(11, 2), 3.0, 5.0, 2.0};
  targets_[0].refined = body;
  targets_[1].bcylinder = {{Vec2(23, 2), 3.0, 4.0, 1.0}};
  const auto own = score(BiasRemoval::target);
  ASSERT_EQ(own.refined.centres.size(), 1U);
  EXPECT_NEAR(own.refined.centres[0].error.norm(), 0.0, kExact);
  ASSERT_EQ(own.refined.cylinders.size(), 1U);
  EXPECT_NEAR(own.refined.cylinders[0].iou, 0.25, kExact);
  EXPECT_NEAR(own.refined.cylinders[0].volume_ratio, 4.0, kExact);
  EXPECT_FALSE(own.refined.cylinders[0].contained.has_value());
  ASSERT_EQ(own.filter.cylinders.size(), 1U);
  EXPECT_NEAR(own.filter.cylinders[0].iou, 0.5, kExact);
}

TEST_F(Errors, OnlyTrueTargetsThatEndedWellCount) {
  targets_[0].state = TargetState::deregistered;  // converged once, then given up
  targets_[1].covariance.setZero();               // singular: no normalised error
  const auto s = score(BiasRemoval::none);
  ASSERT_EQ(s.filter.centres.size(), 1U);
  EXPECT_EQ(s.filter.centres[0].target, TargetId(2));
  EXPECT_TRUE(s.filter.nees().empty());
  for (auto& origin : truth_.detections) origin.object = ObjectId();
  EXPECT_TRUE(score(BiasRemoval::none).filter.centres.empty());
}

}  // namespace
}  // namespace cairn::evaluation
