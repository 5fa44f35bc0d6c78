#include "camera/projection.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.hpp"

namespace cairn::camera {
namespace {

using geometry::Vec2;
using geometry::Vec3;
using survey::Camera;
using survey::CameraModel;

Camera camera_of(CameraModel model) {
  Camera c;
  c.model = model;
  c.width_px = 4000;
  c.height_px = 2250;
  c.fx_px = 2285.7;
  c.fy_px = 2290.1;
  c.cx_px = 1993.0;
  c.cy_px = 1131.0;
  if (model == CameraModel::radial || model == CameraModel::brown) {
    c.k1 = -0.12;
    c.k2 = 0.03;
  }
  if (model == CameraModel::brown) {
    c.k3 = 0.001;
    c.p1 = 0.0011;
    c.p2 = -0.0007;
  }
  if (model == CameraModel::fisheye) {
    c.k1 = -0.03;
    c.k2 = 0.004;
  }
  return c;
}

class EveryModel : public ::testing::TestWithParam<CameraModel> {};

TEST_P(EveryModel, UnprojectInvertsProject) {
  constexpr double kTol_rad = 1e-9;  // the header's promise
  const Camera c = camera_of(GetParam());
  base::Random random(1, "projection", 0);
  for (int i = 0; i < 2000; ++i) {
    const Vec2 pixel(random.uniform(0, 4000), random.uniform(0, 2250));
    const auto ray = unproject(c, pixel);
    ASSERT_TRUE(ray);
    EXPECT_NEAR(ray->norm(), 1.0, 1e-14);
    const auto back = project(c, 7.0 * *ray);
    ASSERT_TRUE(back);
    EXPECT_LT((*back - pixel).norm(), kTol_rad * c.fx_px * 4.0);
  }
}

INSTANTIATE_TEST_SUITE_P(Models, EveryModel,
                         ::testing::Values(CameraModel::pinhole, CameraModel::radial, CameraModel::brown,
                                           CameraModel::fisheye));

// The formula of OpenCV's calib3d page at one point, worked by hand.
TEST(Project, BrownFollowsOpenCvsSigns) {
  Camera c = camera_of(CameraModel::brown);
  const double x = 0.3, y = -0.2, r2 = x * x + y * y;
  const double radial = 1.0 + c.k1 * r2 + c.k2 * r2 * r2 + c.k3 * r2 * r2 * r2;
  const double u = x * radial + 2.0 * c.p1 * x * y + c.p2 * (r2 + 2.0 * x * x);
  const double v = y * radial + c.p1 * (r2 + 2.0 * y * y) + 2.0 * c.p2 * x * y;
  const auto pixel = project(c, {0.6, -0.4, 2.0});
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x(), c.fx_px * u + c.cx_px, 1e-9);
  EXPECT_NEAR(pixel->y(), c.fy_px * v + c.cy_px, 1e-9);
}

TEST(Project, NothingBehindTheCameraNorBeyondTheFold) {
  const Camera c = camera_of(CameraModel::radial);
  EXPECT_FALSE(project(c, {0, 0, -1}));
  EXPECT_FALSE(project(c, {0, 0, 0}));
  Camera barrel = c;
  barrel.k1 = -0.3;
  barrel.k2 = 0.0;
  // r (1 - 0.3 r^2) turns round at r = 1.054: a wide ray would come back into the picture.
  EXPECT_TRUE(project(barrel, {1.0, 0, 1.0}));
  EXPECT_FALSE(project(barrel, {1.5, 0, 1.0}));
}

TEST(Scaled, ScalesPixelsOnly) {
  const Camera c = camera_of(CameraModel::radial);
  const Camera small = scaled(c, 0.4);
  EXPECT_EQ(small.width_px, 1600);
  EXPECT_EQ(small.height_px, 900);
  const Vec3 p(1.0, 0.5, 4.0);
  EXPECT_LT((*project(small, p) - 0.4 * *project(c, p)).norm(), 1e-9);
}

TEST(Footprint, NadirPinholeIsTheScaledImage) {
  Camera c = camera_of(CameraModel::pinhole);
  c.cx_px = 2000;
  c.cy_px = 1125;
  // Looking down, image top to the north: camera x east, y south, z down.
  geometry::RigidTransform T_world_camera;
  T_world_camera.rotation << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  T_world_camera.translation = {10, 20, 42};
  const auto ring = footprint(c, T_world_camera, 2.0, 4);
  ASSERT_EQ(ring.size(), 16U);
  const double expected = (40.0 * 4000 / c.fx_px) * (40.0 * 2250 / c.fy_px);
  EXPECT_NEAR(geometry::signed_area(ring), expected, 1e-6 * expected);
  EXPECT_TRUE(geometry::contains(ring, {10, 20}));
}

TEST(Footprint, EmptyWhenLookingUp) {
  const Camera c = camera_of(CameraModel::pinhole);
  geometry::RigidTransform up;
  up.translation = {0, 0, 10};
  EXPECT_TRUE(footprint(c, up, 0.0).empty());
}

}  // namespace
}  // namespace cairn::camera
