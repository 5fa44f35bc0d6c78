#include "localisation/body_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/parallel.hpp"
#include "localisation/body_solver.hpp"
#include "support/body_views.hpp"

namespace cairn::localisation {
namespace {

using geometry::Mat2;
using geometry::Mat3;
using geometry::Vec2;
using geometry::Vec3;
using testing::BodyViews;

std::vector<survey::Target> fitted(const BodyViews& views, const survey::Target& target,
                                   const BodyFitOptions& options = {}) {
  std::vector<survey::Target> targets{target};
  base::RunContext ctx;
  (void)refine_bodies(targets, views.survey, options, ctx);
  return targets;
}

TEST(BodyModel, SupportOfAnEllipsoidIsThatOfItsDualQuadric) {
  const Body body{{0, 0, 0, 0.3, 0.2, -0.15, -0.2, 0.1, -0.05}, {}};
  const Mat2 a = half_axis_matrix(body.ellipsoid.data());
  Mat3 m = Mat3::Zero();
  m.topLeftCorner<2, 2>() = a;
  m.topRightCorner<2, 1>() = Vec2(0.1, -0.05);
  m(2, 2) = std::exp(-0.2);
  for (int i = 0; i < 20; ++i) {
    const Vec3 n(std::cos(i), std::sin(2.0 * i), std::sin(3.0 * i));
    EXPECT_NEAR(body.support(n), (m.transpose() * n).norm(), 1e-12);
  }
  // exp of a symmetric matrix: its determinant is the exponential of the trace.
  EXPECT_NEAR(a.determinant(), std::exp(0.6), 1e-12);
}

// Mean square 1 over the sphere, and no two alike: Gauss-like quadrature by a fine grid.
TEST(BodyModel, HarmonicsAreOrthonormal) {
  constexpr int kPolar = 200, kAzimuth = 40;
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(kHarmonics, kHarmonics);
  for (int i = 0; i < kPolar; ++i)
    for (int j = 0; j < kAzimuth; ++j) {
      const double z = -1.0 + 2.0 * (i + 0.5) / kPolar, s = std::sqrt(1.0 - z * z);
      const double phi = 2.0 * std::numbers::pi * j / kAzimuth;
      std::array<double, kHarmonics> y;
      harmonics<double>(Vec3(s * std::cos(phi), s * std::sin(phi), z), &y);
      const Eigen::Map<const Eigen::VectorXd> v(y.data(), kHarmonics);
      gram += v * v.transpose() / (kPolar * kAzimuth);
    }
  constexpr double kMidpointRule = 2e-3;  // error of the rule at 200 heights
  EXPECT_LT((gram - Eigen::MatrixXd::Identity(kHarmonics, kHarmonics)).cwiseAbs().maxCoeff(), kMidpointRule);
  std::array<double, kHarmonics> top;
  harmonics<double>(Vec3::UnitZ(), &top);
  EXPECT_NEAR(top[harmonic_index(3, 0)], std::sqrt(7.0), 1e-12);
  EXPECT_NEAR(top[harmonic_index(6, 0)], std::sqrt(13.0), 1e-12);
}

TEST(BodySolver, JacobianIsTheNumericOne) {
  BodyViews views;
  views.circle({0, 0}, 17.0, 50.0, 5);
  views.line(2.0, -14.0, 2.0, 17.0, 4.0);
  for (const double stretch : {0.0, 1e-5, 0.3})
    for (const auto& frame : views.survey.frames) {
      const View view = ideal_view(views.survey.manifest.cameras.front(), frame.T_world_camera);
      const BoxPlanes planes = box_planes(view, {280, 200, 330, 260}, Vec3(0.3, 0.2, 0.5));
      Body body{{0.1, -0.2, 0.3, 0.4, stretch, -stretch, 0.2, 0.1, -0.05}, {}};
      for (std::size_t i = 0; i < kHarmonics; ++i) body.harmonic[i] = 0.02 * std::sin(static_cast<double>(i));
      Eigen::Vector4d residual;
      SideJacobian jacobian;
      ASSERT_TRUE(side_residuals(planes, body, &residual, &jacobian));
      for (std::size_t i = 0; i < kBodyParameters; ++i) {
        constexpr double kStep = 1e-6;
        const auto stepped = [&](double by) {
          Body b = body;
          (i < kEllipsoidParameters ? b.ellipsoid[i] : b.harmonic[i - kEllipsoidParameters]) += by;
          Eigen::Vector4d r;
          EXPECT_TRUE(side_residuals(planes, b, &r, nullptr));
          return r;
        };
        const Eigen::Vector4d numeric = (stepped(kStep) - stepped(-kStep)) / (2.0 * kStep);
        for (int s = 0; s < 4; ++s)
          EXPECT_NEAR(jacobian(s, static_cast<int>(i)), numeric[s], 1e-5 * std::max(1.0, std::abs(numeric[s])));
      }
    }
}

TEST(BodyFit, FindsAnEllipsoidExactlyFromItsBoxes) {
  BodyViews views;
  views.circle({0, 0}, 17.0, 45.0, 24);
  views.line(3.0, -16.0, 4.0, 17.0, 2.0);
  const Vec3 centre(0.4, -0.3, 0.8), axes(1.1, 0.7, 0.9);
  const auto body = testing::ellipsoid(centre, axes, geometry::axis_rotation(Vec3::UnitZ(), base::deg_to_rad(-30.0)));
  const auto target = views.boxes(body, centre + Vec3(0.2, -0.1, 0.15));
  const auto t = fitted(views, target).front();
  ASSERT_TRUE(t.refined) << t.reasons.front();
  printf("%g %g %g | %g %g %g az %g\n", t.refined->centre.x(), t.refined->centre.y(), t.refined->centre.z(),
         t.refined->semi_axes_m.x(), t.refined->semi_axes_m.y(), t.refined->semi_axes_m.z(), t.refined->azimuth_deg);
}

}  // namespace
}  // namespace cairn::localisation
