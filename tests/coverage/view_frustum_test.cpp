#include "coverage/view_frustum.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.hpp"
#include "camera/projection.hpp"
#include "support/views.hpp"

namespace cairn::coverage {
namespace {

using geometry::Vec3;

survey::Camera distorted(survey::CameraModel model, double k1, double k2, double p1) {
  survey::Camera camera = testing::pinhole_camera(2285.7, 4000, 2250);
  camera.model = model;
  camera.k1 = k1;
  camera.k2 = k2;
  camera.p1 = p1;
  return camera;
}

// The planes must never contradict the exact projection.
void check_planes(const survey::Camera& camera, double margin) {
  const CameraBounds bounds = camera_bounds(camera, margin);
  const ViewFrustum view = view_frustum(bounds, testing::looking_at(Vec3(1, 2, 30), Vec3(4, 1, 0)));
  base::Random random(21, "points", 0);
  int inside = 0, outside = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 p(random.uniform(-60, 60), random.uniform(-60, 60), random.uniform(-20, 40));
    const Vec3 in_camera = view.R_camera_world * (p - view.centre);
    const auto pixel = camera::project(camera, in_camera);
    const bool sees = pixel && camera::inside_image(camera, *pixel, margin);
    ASSERT_EQ(view.sees(p), sees);
    (sees ? inside : outside) += 1;
    bool in_outer = true, in_inner = view.has_inner;
    for (const Vec3& n : view.outer) in_outer = in_outer && n.dot(p - view.centre) >= 0.0;
    for (const Vec3& n : view.inner) in_inner = in_inner && n.dot(p - view.centre) > 0.0;
    if (sees) {
      ASSERT_TRUE(in_outer);
    }
    if (in_inner) {
      ASSERT_TRUE(sees);
    }
  }
  EXPECT_GT(inside, 1000);
  EXPECT_GT(outside, 1000);
}

TEST(ViewFrustum, PlanesAgreeWithTheProjection) {
  check_planes(testing::pinhole_camera(2285.7, 4000, 2250), 0.02);
  check_planes(distorted(survey::CameraModel::radial, -0.05, 0.01, 0.0), 0.0);
  check_planes(distorted(survey::CameraModel::radial, 0.05, 0.01, 0.0), 0.02);
  check_planes(distorted(survey::CameraModel::brown, -0.15, 0.05, 0.003), 0.01);
  check_planes(distorted(survey::CameraModel::fisheye, -0.02, 0.003, 0.0), 0.0);
}

TEST(ViewFrustum, FieldsOfViewBeyondHalfATurnAreNotCulled) {
  survey::Camera camera = testing::pinhole_camera(300, 1000, 1000);
  camera.model = survey::CameraModel::fisheye;
  const CameraBounds bounds = camera_bounds(camera, 0.0);
  EXPECT_FALSE(bounds.bounded);
  const ViewFrustum view = view_frustum(bounds, {});
  EXPECT_TRUE(view.sees(Vec3(100, 0, 1)) || !camera::project(camera, Vec3(100, 0, 1)));
  EXPECT_TRUE(view.sees(Vec3(1, 0, 1)));
}

TEST(CameraBounds, MagnificationFollowsTheDistortion) {
  const survey::Camera camera = distorted(survey::CameraModel::radial, -0.08, 0.02, 0.0);
  const CameraBounds bounds = camera_bounds(camera, 0.0);
  for (const double x : {-0.7, -0.31, 0.0, 0.123, 0.6})
    for (const double y : {-0.4, 0.0, 0.3}) {
      // d(r s)/dr times s with s = 1 + k1 r^2 + k2 r^4: the area ratio of a radial map.
      const double r2 = x * x + y * y;
      const double s = 1 + camera.k1 * r2 + camera.k2 * r2 * r2;
      const double slope = 1 + 3 * camera.k1 * r2 + 5 * camera.k2 * r2 * r2;
      EXPECT_NEAR(bounds.magnification(x, y), s * slope, 5e-4) << x << " " << y;
    }
  EXPECT_EQ(camera_bounds(testing::pinhole_camera(1000, 1000, 1000), 0.0).magnification(0.3, 0.1), 1.0);
}

}  // namespace
}  // namespace cairn::coverage
