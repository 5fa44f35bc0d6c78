#include "camera/projection_jacobian.hpp"

#include <gtest/gtest.h>

#include "base/random.hpp"
#include "camera/projection.hpp"

namespace cairn::camera {
namespace {

using geometry::Vec2;
using geometry::Vec3;
using survey::Camera;
using survey::CameraModel;

Camera camera_of(CameraModel model) {
  Camera c;
  c.model = model;
  c.fx_px = 1100.0;
  c.fy_px = 1103.0;
  c.cx_px = 803.0;
  c.cy_px = 596.0;
  if (model == CameraModel::pinhole) return c;
  c.k1 = -0.05;
  c.k2 = 0.02;
  if (model == CameraModel::radial) return c;
  c.k3 = -0.004;
  if (model == CameraModel::fisheye) {
    c.k4 = 0.001;
    return c;
  }
  c.p1 = 0.0011;
  c.p2 = -0.0007;
  return c;
}

class Jacobian : public ::testing::TestWithParam<CameraModel> {};

// Central differences: error of order step^2 times the third derivative, and rounding of order 1e-13 px / step.
constexpr double kStep = 1e-6, kTolPerUnit = 2e-5;

TEST_P(Jacobian, PixelIsThatOfProject) {
  constexpr double kTol_px = 1e-10;  // rounding
  const Camera c = camera_of(GetParam());
  base::Random random(1, "jacobian", 0);
  for (int i = 0; i < 500; ++i) {
    const Vec3 p(random.uniform(-6, 6), random.uniform(-6, 6), random.uniform(8, 40));
    Vec2 pixel;
    PointJacobian by_point;
    ASSERT_TRUE(project_with_jacobian(c, p, IntrinsicsSet::none, pixel, by_point, nullptr));
    const auto expected = project(c, p);
    ASSERT_TRUE(expected);
    EXPECT_LT((pixel - *expected).norm(), kTol_px);
  }
}

TEST_P(Jacobian, ByPointMatchesDifferences) {
  const Camera c = camera_of(GetParam());
  base::Random random(2, "jacobian", 0);
  for (int i = 0; i < 200; ++i) {
    const bool on_axis = i == 0;
    const Vec3 p = on_axis ? Vec3(0, 0, 5) : Vec3(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(4, 9));
    Vec2 pixel;
    PointJacobian by_point;
    ASSERT_TRUE(project_with_jacobian(c, p, IntrinsicsSet::none, pixel, by_point, nullptr));
    for (int a = 0; a < 3; ++a) {
      const Vec3 step = kStep * Vec3::Unit(a);
      const Vec2 slope = (*project(c, p + step) - *project(c, p - step)) / (2.0 * kStep);
      EXPECT_LT((by_point.col(a) - slope).norm(), kTolPerUnit) << "axis " << a << " at " << p.transpose();
    }
  }
}

TEST_P(Jacobian, ByIntrinsicsMatchesDifferences) {
  const Camera c = camera_of(GetParam());
  base::Random random(3, "jacobian", 0);
  for (const auto set : {IntrinsicsSet::focal, IntrinsicsSet::distortion, IntrinsicsSet::radial, IntrinsicsSet::all}) {
    const auto values = intrinsics_of(c, set);
    ASSERT_EQ(static_cast<int>(values.size()), intrinsics_count(c.model, set));
    EXPECT_EQ(with_intrinsics(c, set, values), c);
    for (int i = 0; i < 50; ++i) {
      const Vec3 p(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(4, 9));
      Vec2 pixel;
      PointJacobian by_point;
      IntrinsicsJacobian by_intrinsics;
      ASSERT_TRUE(project_with_jacobian(c, p, set, pixel, by_point, &by_intrinsics));
      for (std::size_t k = 0; k < values.size(); ++k) {
        auto more = values, less = values;
        more[k] += kStep;
        less[k] -= kStep;
        const Vec2 slope =
            (*project(with_intrinsics(c, set, more), p) - *project(with_intrinsics(c, set, less), p)) / (2.0 * kStep);
        EXPECT_LT((by_intrinsics.col(static_cast<Eigen::Index>(k)) - slope).norm(), kTolPerUnit) << "parameter " << k;
      }
    }
  }
}

TEST_P(Jacobian, RefusesPointsBehindTheCamera) {
  Vec2 pixel;
  PointJacobian by_point;
  EXPECT_FALSE(
      project_with_jacobian(camera_of(GetParam()), {0.1, 0.1, -1.0}, IntrinsicsSet::none, pixel, by_point, nullptr));
  EXPECT_FALSE(
      project_with_jacobian(camera_of(GetParam()), {0.1, 0.1, 0.0}, IntrinsicsSet::none, pixel, by_point, nullptr));
}

INSTANTIATE_TEST_SUITE_P(Models, Jacobian,
                         ::testing::Values(CameraModel::pinhole, CameraModel::radial, CameraModel::brown,
                                           CameraModel::fisheye));

TEST(Intrinsics, CountsByModelAndSet) {
  EXPECT_EQ(intrinsics_count(CameraModel::brown, IntrinsicsSet::none), 0);
  EXPECT_EQ(intrinsics_count(CameraModel::brown, IntrinsicsSet::focal), 1);
  EXPECT_EQ(intrinsics_count(CameraModel::pinhole, IntrinsicsSet::radial), 1);
  EXPECT_EQ(intrinsics_count(CameraModel::radial, IntrinsicsSet::radial), 3);
  EXPECT_EQ(intrinsics_count(CameraModel::radial, IntrinsicsSet::distortion), 2);
  EXPECT_EQ(intrinsics_count(CameraModel::radial, IntrinsicsSet::all), 5);
  EXPECT_EQ(intrinsics_count(CameraModel::brown, IntrinsicsSet::all), 8);
  EXPECT_EQ(intrinsics_count(CameraModel::fisheye, IntrinsicsSet::all), 7);
}

}  // namespace
}  // namespace cairn::camera
