#include "coverage/sight_information.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <numeric>

#include "base/angle.hpp"
#include "base/random.hpp"
#include "camera/projection.hpp"
#include "coverage/coverage.hpp"
#include "support/meshes.hpp"
#include "support/views.hpp"

namespace cairn::coverage {
namespace {

using geometry::Mat3;
using geometry::Vec2;
using geometry::Vec3;

constexpr int kDraws = 4000;          // a standard deviation of them is known to 1.1 %
constexpr double kMonteCarlo = 0.10;  // relative, asked for
constexpr double kClosedForm = 1e-4;  // relative, single precision

Mat3 turned_by(const Vec3& rotation) {
  const double angle = rotation.norm();
  return angle > 0.0 ? Eigen::AngleAxisd(angle, rotation / angle).toRotationMatrix() : Mat3(Mat3::Identity());
}

// Gauss-Newton on the pixel residuals with the weights of each view, by numerical derivatives of the full projection.
Vec3 triangulate(const ViewSet& set, const std::vector<Vec2>& pixels, const std::vector<Eigen::Matrix2d>& weights,
                 Vec3 p) {
  for (int step = 0; step < 6; ++step) {
    Mat3 normal = Mat3::Zero();
    Vec3 right = Vec3::Zero();
    for (std::size_t i = 0; i < set.views.size(); ++i) {
      const auto at = [&](const Vec3& q) {
        return *camera::project_world(set.cameras[0], set.views[i].T_world_camera, q);
      };
      constexpr double kStep = 1e-5;
      Eigen::Matrix<double, 2, 3> J;
      for (int k = 0; k < 3; ++k)
        J.col(k) = (at(p + kStep * Vec3::Unit(k)) - at(p - kStep * Vec3::Unit(k))) / (2 * kStep);
      normal += J.transpose() * weights[i] * J;
      right += J.transpose() * weights[i] * (pixels[i] - at(p));
    }
    p += normal.ldlt().solve(right);
  }
  return p;
}

// Spread of triangulated points when pixels and poses are disturbed, against the prediction for a small facet there.
void compare(ViewSet set, const NoiseOptions& noise, const Vec3& target, std::uint64_t seed) {
  geometry::TriangleMesh mesh;
  mesh.vertices = {target + Vec3(0.01, 0, 0), target + Vec3(-0.005, 0.008, 0), target + Vec3(-0.005, -0.008, 0)};
  mesh.triangles = {{0, 1, 2}};
  base::RunContext ctx;
  CoverageOptions options;
  options.noise = noise;
  const FacetCoverage predicted = coverage(mesh, visibility::Scene(mesh), set, options, ctx);
  ASSERT_EQ(predicted.views[0], set.views.size());

  // Errors of each view as the options say, and the weights that belong to them (by drawing, not by formula).
  base::Random random(seed, "sigma", 0);
  const auto normal3 = [&random] { return Vec3(random.normal(), random.normal(), random.normal()); };
  const auto disturbed = [&](const View& view) {
    const double xy = view.sigma_xy_m > 0 ? view.sigma_xy_m : noise.position_sigma_m;
    const double z = view.sigma_z_m > 0 ? view.sigma_z_m : noise.position_sigma_m;
    const double turn = base::deg_to_rad(view.sigma_rot_deg > 0 ? view.sigma_rot_deg : noise.rotation_sigma_deg);
    geometry::RigidTransform T = view.T_world_camera;
    T.rotation = turned_by(turn * normal3()) * T.rotation;
    const Vec3 shift = normal3();
    T.translation += Vec3(xy * shift.x(), xy * shift.y(), z * shift.z());
    return T;
  };
  const auto measured = [&](const View& view) {
    const Vec2 exact = *camera::project_world(set.cameras[0], disturbed(view), target);
    return Vec2(exact + noise.pixel_sigma_px * Vec2(random.normal(), random.normal()));
  };
  std::vector<Eigen::Matrix2d> weights;
  for (const View& view : set.views) {
    const Vec2 mean = *camera::project_world(set.cameras[0], view.T_world_camera, target);
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
    for (int i = 0; i < kDraws; ++i) {
      const Vec2 r = measured(view) - mean;
      covariance += r * r.transpose() / kDraws;
    }
    weights.push_back(covariance.inverse());
  }
  Mat3 spread = Mat3::Zero();
  for (int i = 0; i < kDraws; ++i) {
    std::vector<Vec2> pixels;
    for (const View& view : set.views) pixels.push_back(measured(view));
    const Vec3 error = triangulate(set, pixels, weights, target) - target;
    spread += error * error.transpose() / kDraws;
  }
  const double largest = std::sqrt(Eigen::SelfAdjointEigenSolver<Mat3>(spread).eigenvalues()[2]);
  const double expected_max = 1000.0 * largest, expected_z = 1000.0 * std::sqrt(spread(2, 2));
  EXPECT_NEAR(static_cast<double>(predicted.sigma_max_mm[0]), expected_max, kMonteCarlo * expected_max);
  EXPECT_NEAR(static_cast<double>(predicted.sigma_z_mm[0]), expected_z, kMonteCarlo * expected_z);
}

ViewSet views_from(const std::vector<Vec3>& places, const Vec3& target) {
  ViewSet set;
  set.cameras.push_back(testing::pinhole_camera(2285.7, 4000, 2250));
  for (const Vec3& place : places) testing::add_view(set, place, target);
  return set;
}

TEST(PredictedSigma, AgreesWithMonteCarlo) {
  const Vec3 target(3, 2, 0);
  // A pair, a nadir strip whose frames do not look at the point, a ring, with each error in turn the greatest.
  compare(views_from({{0, 0, 40}, {8, 0, 40}}, {4, 0, 0}), {0.5, 0.0, 0.0}, target, 1);
  compare(views_from({{-20, 3, 40}, {-5, 0, 41}, {8, 1, 39}, {20, -4, 40}}, {4, 0, 0}), {0.5, 0.05, 0.0}, target, 2);
  ViewSet nadir;
  nadir.cameras.push_back(testing::pinhole_camera(2285.7, 4000, 2250));
  for (const double east : {-24.0, -12.0, 1.0, 13.0, 26.0})
    testing::add_view(nadir, Vec3(east, 4, 40), Vec3(east, 4, 0));
  compare(nadir, {1.0, 0.02, 0.05}, target, 3);
  ViewSet ring = views_from({{12, 0, 6}, {0, 11, 5}, {-10, 3, 7}, {4, -9, 8}}, {3, 2, 0.5});
  for (std::size_t i = 0; i < ring.views.size(); ++i) {
    ring.views[i].sigma_xy_m = 0.01 + 0.02 * static_cast<double>(i);
    ring.views[i].sigma_z_m = 0.05;
    ring.views[i].sigma_rot_deg = 0.1;
  }
  compare(ring, {0.7, 0.5, 3.0}, target, 4);
}

TEST(PredictedSigma, AgreesWithMonteCarloUnderDistortion) {
  ViewSet set = views_from({{-14, 3, 40}, {-5, 0, 41}, {8, 1, 39}, {17, -4, 40}}, {4, 0, 0});
  set.cameras[0].model = survey::CameraModel::brown;
  set.cameras[0].k1 = -0.08;
  set.cameras[0].k2 = 0.02;
  set.cameras[0].p1 = 0.001;
  compare(set, {0.8, 0.02, 0.02}, {6, 5, 0}, 5);
}

TEST(PredictedSigma, OfTwoSymmetricViewsIsClosedForm) {
  // Two cameras at height h, +-b/2 to each side, straight down, no pose errors. Pixel error s/f in both axes:
  // east h s / (f sqrt 2), up 2 h^2 s / (f b sqrt 2).
  const double h = 30.0, b = 10.0, f = 1000.0;
  geometry::TriangleMesh mesh;
  mesh.vertices = {Vec3(0.01, 0, 0), Vec3(-0.005, 0.008, 0), Vec3(-0.005, -0.008, 0)};
  mesh.triangles = {{0, 1, 2}};
  ViewSet set;
  set.cameras.push_back(testing::pinhole_camera(f, 1000, 1000));
  testing::add_view(set, Vec3(-b / 2, 0, h), Vec3(-b / 2, 0, 0));
  testing::add_view(set, Vec3(b / 2, 0, h), Vec3(b / 2, 0, 0));
  CoverageOptions options;
  options.noise = {1.0, 0.0, 0.0};
  base::RunContext ctx;
  const FacetCoverage result = coverage(mesh, visibility::Scene(mesh), set, options, ctx);
  const double up_mm = 1000.0 * 2.0 * h * h / (f * b * std::sqrt(2.0));
  EXPECT_NEAR(static_cast<double>(result.sigma_z_mm[0]), up_mm, kClosedForm * up_mm);
  EXPECT_NEAR(static_cast<double>(result.sigma_max_mm[0]), up_mm, kClosedForm * up_mm);
}

TEST(PredictedSigma, IsNotGivenWhereTheLinesDoNotFixThePoint) {
  EXPECT_TRUE(std::isnan(point_sigma({}).largest_m));
  EXPECT_TRUE(std::isnan(point_sigma({1.0, 0.0, 0.0, 1.0, 0.0, 0.0}).up_m));  // nothing known of up
  const PointSigma known = point_sigma({4.0, 0.0, 0.0, 16.0, 0.0, 25.0});
  EXPECT_DOUBLE_EQ(known.largest_m, 0.5);
  EXPECT_DOUBLE_EQ(known.up_m, 0.2);
}

}  // namespace
}  // namespace cairn::coverage
