// Are the sigmas true? Monte Carlo over seeds, one frame a seed.
#include "adjustment/bundle_covariance.hpp"

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "support/block_survey.hpp"

namespace cairn::adjustment {
namespace {

using geometry::Vec3;
using testing::BlockSurvey;

constexpr int kSeeds = 60;
// 95 % band of the mean of 60 values of chi-square with 6 degrees of freedom (chi2(360) / 60), widened by 10 % on both
// sides for the noise level, which is estimated, and for the losses.
constexpr double kLow = 5.17 * 0.9, kHigh = 6.91 * 1.1;

// Normalised squared error of one pose.
double squared_error(const BundleResult& result, const survey::Frame& truth, std::size_t f) {
  const auto& pose = result.frames[f].T_world_camera;
  Eigen::Matrix<double, 6, 1> error;
  error << log_rotation(truth.T_world_camera.rotation.transpose() * pose.rotation),
      pose.translation - truth.T_world_camera.translation;
  return error.dot(result.frame_reports[f].covariance.llt().solve(error));
}

testing::BlockOptions small(std::uint64_t seed) {
  return {.columns = 3, .rows = 3, .points = 150, .noise_px = 0.6, .seed = seed};
}

TEST(PoseCovariance, HonestWithPriors) {
  double sum = 0.0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const BlockSurvey block(small(static_cast<std::uint64_t>(seed) + 1));
    auto problem = block.perturbed(0.4, 1.0, static_cast<std::uint64_t>(seed));
    for (auto& frame : problem.frames) {
      frame.sigma_xy_m = frame.sigma_z_m = 0.4;
      frame.sigma_rot_deg = 1.0;
    }
    base::RunContext ctx;
    BundleOptions options;
    options.prior_loss_scale = 0.0;  // the priors' noise is normal
    const auto result = adjust_bundle(problem, options, ctx);
    const auto f = static_cast<std::size_t>(seed) % problem.frames.size();
    sum += squared_error(result, block.truth.frames[f], f);
  }
  EXPECT_GT(sum / kSeeds, kLow);
  EXPECT_LT(sum / kSeeds, kHigh);
}

TEST(PoseCovariance, HonestWithControlPoints) {
  double sum = 0.0, check = 0.0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const BlockSurvey block(small(static_cast<std::uint64_t>(seed) + 1));
    auto problem = block.perturbed(0.4, 1.0, static_cast<std::uint64_t>(seed));
    base::Random random(static_cast<std::uint64_t>(seed), "control", 0);
    for (const auto& place : {Vec3(0, 0, 0), Vec3(24, 0, 1), Vec3(0, 24, 2), Vec3(24, 24, -1), Vec3(12, 12, 0)}) {
      survey::ControlPoint point;
      point.name = "p";
      point.sigma_xy_m = 0.03;
      point.sigma_z_m = 0.05;
      point.p_world = place + testing::normal3(random, 1.0).cwiseProduct(Vec3(0.03, 0.03, 0.05));
      point.observations = block.seen(place, random, 1.0);
      problem.control.push_back(point);
    }
    base::RunContext ctx;
    const auto result = adjust_bundle(problem, {}, ctx);
    ASSERT_EQ(result.gauge, BundleGauge::control);
    const auto f = static_cast<std::size_t>(seed) % problem.frames.size();
    sum += squared_error(result, block.truth.frames[f], f);
    check += result.control[4].after.norm();
  }
  EXPECT_GT(sum / kSeeds, kLow);
  EXPECT_LT(sum / kSeeds, kHigh);
  EXPECT_LT(check / kSeeds, 0.05);
}

TEST(PoseCovariance, HonestWhereTheBlockIsAligned) {
  double sum = 0.0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const BlockSurvey block(small(static_cast<std::uint64_t>(seed) + 1));
    auto problem = block.truth;  // the truth is the start: the alignment is to it
    base::RunContext ctx;
    auto result = adjust_bundle(problem, {}, ctx);
    ASSERT_EQ(result.gauge, BundleGauge::aligned);
    const auto f = static_cast<std::size_t>(seed) % problem.frames.size();
    sum += squared_error(result, block.truth.frames[f], f);
  }
  EXPECT_GT(sum / kSeeds, kLow);
  EXPECT_LT(sum / kSeeds, kHigh);
}

TEST(PoseCovariance, BlocksAloneAreTooSmall) {
  const BlockSurvey block(small(1));
  auto problem = block.perturbed(0.4, 1.0, 1);
  for (auto& frame : problem.frames) frame.sigma_xy_m = frame.sigma_z_m = frame.sigma_rot_deg = 0.4;
  base::RunContext ctx;
  BundleOptions options;
  const auto full = adjust_bundle(problem, options, ctx);
  EXPECT_EQ(full.covariance_method, "full");
  options.covariance = "block";
  const auto alone = adjust_bundle(problem, options, ctx);
  EXPECT_EQ(alone.covariance_method, "block");
  for (std::size_t f = 0; f < full.frames.size(); ++f) {
    EXPECT_LT(alone.frame_reports[f].covariance(3, 3), full.frame_reports[f].covariance(3, 3));
    EXPECT_GT(alone.frames[f].sigma_xy_m, 0.0);
  }
}

TEST(RotationIncrements, JacobiansMatchDifferences) {
  constexpr double kStep = 1e-6, kTol = 1e-8;  // second order in the step
  base::Random random(1, "so3", 0);
  for (int i = 0; i < 100; ++i) {
    const Vec3 w = testing::normal3(random, i < 50 ? 1.0 : 1e-5);
    const geometry::Mat3 right = right_jacobian(w), inverse = inverse_right_jacobian(w);
    EXPECT_LT((right * inverse - geometry::Mat3::Identity()).norm(), 1e-9);
    EXPECT_LT((log_rotation(exp_rotation(w)) - w).norm(), w.norm() < 3.1 ? 1e-12 : 10.0);
    for (int a = 0; a < 3; ++a) {
      const Vec3 d = kStep * Vec3::Unit(a);
      const Vec3 slope = log_rotation(exp_rotation(w - d).transpose() * exp_rotation(w + d)) / (2.0 * kStep);
      EXPECT_LT((right.col(a) - slope).norm(), kTol);
    }
  }
}

}  // namespace
}  // namespace cairn::adjustment
