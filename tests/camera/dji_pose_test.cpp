#include "camera/dji_pose.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "base/random.hpp"

namespace cairn::camera {
namespace {

using geometry::Mat3;
using geometry::Vec3;

constexpr double kRounding = 1e-15;  // of direction cosines: a few units in the last place

GimbalAngles degrees(double yaw, double pitch, double roll) {
  return {base::Angle::from_deg(yaw), base::Angle::from_deg(pitch), base::Angle::from_deg(roll)};
}

void expect_near(const Vec3& found, const Vec3& expected) {
  EXPECT_LT((found - expected).norm(), kRounding) << found.transpose() << " instead of " << expected.transpose();
}

const Vec3 kEast = Vec3::UnitX(), kNorth = Vec3::UnitY(), kUp = Vec3::UnitZ();
const Vec3 kRight = Vec3::UnitX(), kDown = Vec3::UnitY(), kForward = Vec3::UnitZ();  // of the camera

TEST(DjiPose, LevelAndNorthLooksNorthWithEastToTheRight) {
  const Mat3 r = enu_from_camera(degrees(0, 0, 0));
  expect_near(r * kForward, kNorth);
  expect_near(r * kRight, kEast);
  expect_near(r * kDown, -kUp);
}

TEST(DjiPose, NadirAndNorthLooksDownWithNorthAtTheTop) {
  const Mat3 r = enu_from_camera(degrees(0, -90, 0));
  expect_near(r * kForward, -kUp);
  expect_near(r * -kDown, kNorth);
  expect_near(r * kRight, kEast);
}

// A gimbal past nadir writes a flipped twin: heading turned by 180 degrees, roll 180.
TEST(DjiPose, ShotPastNadirEqualsItsUnflippedTwin) {
  for (const double yaw : {0.0, 30.0, -140.0}) {
    const Mat3 flipped = enu_from_camera(degrees(yaw + 180.0, -80.0, 180.0));
    const Mat3 plain = enu_from_camera(degrees(yaw, -100.0, 0.0));
    EXPECT_LT((flipped - plain).cwiseAbs().maxCoeff(), kRounding) << "yaw " << yaw;
  }
}

TEST(DjiPose, YawIsClockwiseFromNorth) {
  expect_near(enu_from_camera(degrees(90, 0, 0)) * kForward, kEast);
  expect_near(enu_from_camera(degrees(-90, -90, 0)) * -kDown, -kEast);
}

TEST(DjiPose, PositiveRollLowersTheRightSideOfTheCamera) {
  expect_near(enu_from_camera(degrees(0, 0, 90)) * kRight, -kUp);
}

TEST(DjiPose, CameraBelowALevelVehicleLooksDownWithTheNoseAtTheTop) {
  const Mat3 r = enu_from_camera(degrees(90, 0, 0), CameraMount::nadir);
  expect_near(r * kForward, -kUp);
  expect_near(r * -kDown, kEast);
  // Nose up by 10 degrees: the camera looks forward of the nadir.
  EXPECT_GT((enu_from_camera(degrees(90, 10, 0), CameraMount::nadir) * kForward).x(), 0.1);
}

TEST(DjiPose, AlwaysARotation) {
  base::Random random(3, "dji", 0);
  for (int i = 0; i < 200; ++i)
    for (const auto mount : {CameraMount::forward, CameraMount::nadir}) {
      const Mat3 r = enu_from_camera(
          degrees(random.uniform(-180, 180), random.uniform(-90, 90), random.uniform(-180, 180)), mount);
      EXPECT_LT((r.transpose() * r - Mat3::Identity()).cwiseAbs().maxCoeff(), 4 * kRounding);
      EXPECT_GT(r.determinant(), 0.0);
    }
}

TEST(DjiPose, HalfTurnKeepsTheAxisAndSwapsTheSides) {
  const Mat3 r = enu_from_camera(degrees(40, -90, 0)), turned = turned_half(r);
  EXPECT_EQ(turned * kForward, r * kForward);
  EXPECT_EQ(turned * kRight, -(r * kRight));
  EXPECT_EQ(turned * kDown, -(r * kDown));
  EXPECT_LT((turned - enu_from_camera(degrees(-140, -90, 0))).cwiseAbs().maxCoeff(), kRounding);
}

}  // namespace
}  // namespace cairn::camera
