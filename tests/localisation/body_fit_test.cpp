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
  constexpr double kMidpointRule = 5e-3;  // error of the rule at 200 heights
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

BodyFitOptions plain_ellipsoid() {
  BodyFitOptions options;
  options.shape = "ellipsoid";
  return options;
}

BodyViews around() {
  BodyViews views;
  views.circle({0, 0}, 17.0, 45.0, 24);
  views.line(3.0, -16.0, 4.0, 17.0, 2.0);
  return views;
}

void expect_sound(const survey::Target& target) {
  ASSERT_TRUE(target.refined.has_value() || !target.reasons.empty());
  if (!target.refined) return;
  const auto& r = *target.refined;
  EXPECT_TRUE(r.centre.allFinite() && r.covariance.allFinite() && r.semi_axes_m.allFinite());
  EXPECT_TRUE(std::isfinite(r.azimuth_deg) && std::isfinite(r.rms_px));
  EXPECT_GE(r.cylinder.radius, 0.0);
  EXPECT_LE(r.cylinder.bottom, r.cylinder.top);
}

TEST(BodyFit, FindsAnEllipsoidExactlyFromItsBoxes) {
  constexpr double kExact = 1e-6;  // m, deg
  auto views = around();
  const Vec3 centre(0.4, -0.3, 0.8), axes(1.1, 0.7, 0.9);
  const auto body = testing::ellipsoid(centre, axes, geometry::axis_rotation(Vec3::UnitZ(), base::deg_to_rad(-30.0)));
  const auto target = views.boxes(body, centre + Vec3(0.2, -0.1, 0.15));
  auto options = plain_ellipsoid();
  options.sigma_px = 0.01;  // boxes without error leave nothing to the priors
  options.sigma_size = 0.0;
  const auto t = fitted(views, target, options).front();
  ASSERT_TRUE(t.refined) << t.reasons.front();
  EXPECT_LT((t.refined->centre - centre).norm(), kExact);
  EXPECT_LT((t.refined->semi_axes_m - axes).norm(), kExact);
  EXPECT_NEAR(t.refined->azimuth_deg, 120.0, 1e-4);  // 1.1 m along east, turned by 30 deg clockwise
  EXPECT_LT(t.refined->rms_px, kExact);
  EXPECT_EQ(t.refined->boxes, t.detections.size());
  EXPECT_EQ(t.refined->rejected_boxes, 0U);
}

// A lying ellipsoid turned any way has its level mid-section, height and lean: the cylinder's centre is its own.
TEST(BodyFit, FindsATiltedEllipsoid) {
  auto views = around();
  const Vec3 centre(0.4, -0.3, 0.8);
  const auto body = testing::ellipsoid(centre, {1.1, 0.7, 0.9}, geometry::axis_rotation(Vec3(1, 2, 2) / 3.0, 0.5));
  auto options = plain_ellipsoid();
  options.sigma_px = 0.01;
  options.sigma_size = 0.0;
  const auto t = fitted(views, views.boxes(body, centre), options).front();
  ASSERT_TRUE(t.refined) << t.reasons.front();
  EXPECT_LT((t.refined->centre - centre).norm(), 1e-6);
  EXPECT_NEAR(t.refined->cylinder.height(), 2.0 * std::sqrt(body.q(2, 2)), 1e-4);
}

TEST(BodyFit, FollowsTheLens) {
  auto camera = testing::r200();
  camera.model = survey::CameraModel::brown;
  camera.k1 = -0.15;
  camera.k2 = 0.03;
  BodyViews views(camera);
  views.circle({0, 0}, 17.0, 60.0, 24);
  views.line(3.0, -16.0, 4.0, 17.0, 2.0);
  const Vec3 centre(0.4, -0.3, 0.8), axes(1.1, 0.7, 0.9);
  // Its surface as points, because the outline of a body in a distorted image is no conic.
  std::vector<Vec3> surface;
  constexpr int kSteps = 120;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j < 2 * kSteps; ++j) {
      const double polar = std::numbers::pi * i / kSteps, turn = std::numbers::pi * j / kSteps;
      surface.push_back(centre + axes.cwiseProduct(Vec3(std::sin(polar) * std::cos(turn),
                                                        std::sin(polar) * std::sin(turn), std::cos(polar))));
    }
  const auto t = fitted(views, views.boxes(surface, centre), plain_ellipsoid()).front();
  ASSERT_TRUE(t.refined) << t.reasons.front();
  EXPECT_LT((t.refined->centre - centre).norm(), 0.01);  // m; a side is undistorted at its middle alone
  EXPECT_LT(t.refined->rms_px, 0.2);
}

// The stated covariance against the scatter of the same fit under drawn errors.
TEST(BodyFit, CovarianceIsTheScatter) {
  const Vec3 centre(0.4, -0.3, 0.8);
  const auto body = testing::ellipsoid(centre, {1.1, 0.8, 0.9});
  constexpr int kRuns = 600;
  Mat3 scatter = Mat3::Zero(), stated = Mat3::Zero();
  for (int run = 0; run < kRuns; ++run) {
    auto views = around();
    const auto target = views.boxes(body, centre, 2.0, static_cast<std::uint64_t>(run) + 1);
    auto options = plain_ellipsoid();
    options.sigma_px = 2.0;
    options.sigma_size = 0.0;
    options.assumed_noise = true;
    options.loss_scale = 100.0;  // normal errors: nothing to weigh down
    const auto t = fitted(views, target, options).front();
    ASSERT_TRUE(t.refined);
    const Vec3 d = t.refined->centre - centre;
    scatter += d * d.transpose() / kRuns;
    stated += t.refined->covariance / kRuns;
  }
  constexpr double kWithin = 0.1;  // a standard deviation from 600 runs is known to 3 %
  for (int a = 0; a < 3; ++a)
    EXPECT_NEAR(std::sqrt(stated(a, a)) / std::sqrt(scatter(a, a)), 1.0, kWithin) << "axis " << a;
}

TEST(BodyFit, LeavesFalseBoxesOut) {
  auto views = around();
  const Vec3 centre(0.4, -0.3, 0.8);
  auto target = views.boxes(testing::ellipsoid(centre, {1.1, 0.7, 0.9}), centre, 1.0, 5);
  for (const std::size_t i : {3U, 11U, 20U}) {
    auto& box = views.survey.detections[i].box;
    box = {box.xmin + 60.0, box.ymin - 40.0, box.xmax + 90.0, box.ymax - 30.0};
  }
  const auto t = fitted(views, target, plain_ellipsoid()).front();
  ASSERT_TRUE(t.refined);
  EXPECT_EQ(t.refined->rejected_boxes, 3U);
  EXPECT_LT((t.refined->centre - centre).norm(), 0.08);  // m
}

// The side at the border is where the image ends, not the object.
TEST(BodyFit, UsesOfACutBoxWhatIsInside) {
  BodyViews views;
  for (double north = -22.0; north < 6.0; north += 1.0)
    views.frame(Vec3(-13.5, north, 17.0), testing::looking(0.0, base::deg_to_rad(60.0)));
  views.circle({0, 0}, 17.0, 45.0, 8);
  const Vec3 centre(0.4, -0.3, 0.8);
  const auto target = views.boxes(testing::ellipsoid(centre, {1.1, 0.7, 0.9}), centre);
  std::size_t cut = 0;
  for (const auto& d : views.survey.detections) cut += d.box.xmax >= 640.0 ? 1U : 0U;
  ASSERT_GE(cut, 5U);
  auto options = plain_ellipsoid();
  options.sigma_px = 0.01;
  options.sigma_size = 0.0;
  const auto t = fitted(views, target, options).front();
  ASSERT_TRUE(t.refined);
  EXPECT_LT((t.refined->centre - centre).norm(), 1e-6);
}

TEST(BodyFit, SaysWhyNot) {
  const Vec3 centre(0.4, -0.3, 0.8);
  const auto body = testing::ellipsoid(centre, {1.1, 0.7, 0.9});
  const auto reason_of = [](const BodyViews& views, const survey::Target& target) {
    const auto t = fitted(views, target).front();
    expect_sound(t);
    EXPECT_FALSE(t.refined.has_value());
    return t.reasons.empty() ? std::string() : t.reasons.back();
  };
  {
    BodyViews views;
    views.circle({0, 0}, 17.0, 45.0, 2);
    EXPECT_EQ(reason_of(views, views.boxes(body, centre)), "fit_too_few_boxes");
  }
  {
    BodyViews views;
    for (int i = 0; i < 5; ++i) views.frame(Vec3(0.01 * i, -17.0, 17.0), testing::looking(0.0, base::deg_to_rad(45.0)));
    EXPECT_EQ(reason_of(views, views.boxes(body, centre)), "fit_one_direction");
  }
  {
    auto views = around();
    auto target = views.boxes(body, centre);
    for (auto& d : views.survey.detections) d.box.xmax = d.box.xmin;  // zero area
    EXPECT_EQ(reason_of(views, target), "fit_too_few_boxes");
  }
  {
    auto views = around();
    auto target = views.boxes(body, centre);
    for (auto& d : views.survey.detections) d.box.ymin = std::nan("");
    EXPECT_EQ(reason_of(views, target), "fit_too_few_boxes");
  }
  {
    auto views = around();
    auto target = views.boxes(body, centre);
    target.centre = Vec3(0.0, 0.0, 200.0);  // behind every camera
    EXPECT_EQ(reason_of(views, target), "fit_too_few_boxes");
  }
  {
    auto views = around();
    auto target = views.boxes(body, centre);
    for (auto& f : views.survey.frames) f.T_world_camera.translation.x() = std::nan("");
    EXPECT_EQ(reason_of(views, target), "fit_too_few_boxes");
  }
}

// Boxes that fit no body at all: a reason or a finite answer, never NaN.
TEST(BodyFit, StaysFiniteOnNonsense) {
  base::Random random(9, "nonsense", 0);
  for (int run = 0; run < 20; ++run) {
    auto views = around();
    auto target = views.boxes(testing::ellipsoid({0.4, -0.3, 0.8}, {1.1, 0.7, 0.9}), {0.4, -0.3, 0.8});
    for (auto& d : views.survey.detections) {
      const double x = random.uniform(10.0, 500.0), y = random.uniform(10.0, 400.0);
      d.box = {x, y, x + random.uniform(0.01, 120.0), y + random.uniform(0.01, 60.0)};
    }
    expect_sound(fitted(views, target).front());
  }
}

TEST(BodyFit, LeavesOtherStatesAlone) {
  auto views = around();
  auto target = views.boxes(testing::ellipsoid({0.4, -0.3, 0.8}, {1.1, 0.7, 0.9}), {0.4, -0.3, 0.8});
  target.state = survey::TargetState::converging;
  const auto t = fitted(views, target).front();
  EXPECT_FALSE(t.refined);
  EXPECT_TRUE(t.reasons.empty());
}

TEST(BodyFit, DoesNotDependOnThreads) {
  auto views = around();
  std::vector<survey::Target> one, many;
  for (int i = 0; i < 6; ++i) {
    const Vec3 centre(0.4 + i, -0.3 - i, 0.8);
    one.push_back(
        views.boxes(testing::ellipsoid(centre, {1.1, 0.7, 0.9}), centre, 2.0, static_cast<std::uint64_t>(i) + 1));
    one.back().id = survey::TargetId(i + 1);
  }
  many = one;
  base::RunContext ctx;
  {
    const base::ThreadLimit limit(1);
    (void)refine_bodies(one, views.survey, {}, ctx);
  }
  (void)refine_bodies(many, views.survey, {}, ctx);
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_TRUE(one[i].refined && many[i].refined);
    EXPECT_EQ(one[i].refined->centre, many[i].refined->centre);
    EXPECT_EQ(one[i].refined->covariance, many[i].refined->covariance);
  }
}

}  // namespace
}  // namespace cairn::localisation
