#include "localisation/points.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <cmath>
#include <set>

namespace cairn::localisation {
namespace {

using geometry::Mat3;
using geometry::PixelBox;
using geometry::Vec3;

// A camera 20 m up that looks straight down: x east, y south.
View nadir(double height = 20.0) {
  View view;
  view.T_world_camera.rotation << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  view.T_world_camera.translation = {0, 0, height};
  view.fx_px = view.fy_px = 1000.0;
  view.cx_px = view.cy_px = 500.0;
  return view;
}

struct FillMoments {
  double deviation, quarter, rim;
};

FillMoments moments(BoxFill fill) {
  const PixelBox box{400, 400, 600, 600};
  base::Random random(1, "test", 0);
  const Points points = generate_points(nadir(), box, 200000, {10.0, 10.0001}, fill, random);
  double squares = 0.0, quarter = 0.0, rim = 0.0;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const auto p = nadir().project(points.row(i).transpose());
    const double x = (p->x() - 500.0) / 200.0, y = (p->y() - 500.0) / 200.0;  // -0.5..0.5 over the box
    squares += x * x;
    quarter += std::abs(x) < 0.25 && std::abs(y) < 0.25 ? 1.0 : 0.0;
    rim += std::abs(x) > 0.4 || std::abs(y) > 0.4 ? 1.0 : 0.0;
  }
  const auto n = static_cast<double>(points.rows());
  return {std::sqrt(squares / n), quarter / n, rim / n};
}

// Values of the two samplers (2e8 draws); 2e5 draws here: five standard errors of a share, 5 x 0.001.
constexpr double kShare = 0.005;

TEST(GeneratePoints, CornerWeightsCrowdTheCentreAsAlgorithmOneDoes) {
  const auto m = moments(BoxFill::corner_weights);
  EXPECT_NEAR(m.deviation, 0.1614, 0.0015);
  EXPECT_NEAR(m.quarter, 0.759, kShare);
  EXPECT_NEAR(m.rim, 0.0283, 0.002);
}

TEST(GeneratePoints, UniformFillIsUniform) {
  const auto m = moments(BoxFill::uniform);
  EXPECT_NEAR(m.deviation, 0.2887, 0.002);
  EXPECT_NEAR(m.quarter, 0.25, kShare);
  EXPECT_NEAR(m.rim, 0.36, kShare);
}

TEST(GeneratePoints, DepthIsUniformInItsRange) {
  base::Random random(2, "test", 0);
  const Points points = generate_points(nadir(), {450, 450, 550, 550}, 100000, {5.0, 15.0}, BoxFill::uniform, random);
  const Eigen::ArrayXd depth = 20.0 - points.col(2).array();
  EXPECT_GE(depth.minCoeff(), 5.0);
  EXPECT_LE(depth.maxCoeff(), 15.0);
  EXPECT_NEAR(depth.mean(), 10.0, 0.05);  // 5 standard errors
  EXPECT_NEAR(std::sqrt((depth - depth.mean()).square().mean()), 10.0 / std::sqrt(12.0), 0.03);
}

TEST(Entropy, ConstantAndThresholdsOfTheTable) {
  EXPECT_NEAR(*differential_entropy(Mat3::Identity()), 4.2568155996, 1e-10);
  // 3.0 nats belong to |Sigma| = 0.0810 m^6, isotropic sigma 0.658 m; 2.65 to sigma 0.585 m.
  EXPECT_NEAR(*differential_entropy(Mat3::Identity() * 0.658 * 0.658), 3.0, 0.003);
  EXPECT_NEAR(*differential_entropy(Mat3::Identity() * 0.585 * 0.585), 2.65, 0.003);
  Mat3 scaled = Mat3::Identity();
  scaled(0, 0) = 0.0810;
  EXPECT_NEAR(*differential_entropy(scaled), 3.0, 0.001);
}

TEST(Entropy, IsOfTheDeterminantWhateverTheAxes) {
  Mat3 a;
  a << 2.0, 0.3, -0.1, 0.3, 1.0, 0.2, -0.1, 0.2, 0.5;
  EXPECT_NEAR(*differential_entropy(a), 4.2568155996 + 0.5 * std::log(a.determinant()), 1e-9);
}

TEST(Entropy, EmptyForSingularOrNonFinite) {
  EXPECT_FALSE(differential_entropy(Mat3::Zero()));
  Mat3 flat = Mat3::Identity();
  flat(2, 2) = 0.0;
  EXPECT_FALSE(differential_entropy(flat));
  flat(2, 2) = std::nan("");
  EXPECT_FALSE(differential_entropy(flat));
}

TEST(Divergence, OrderOfTheArguments) {
  const Gaussian wide{Vec3::Zero(), Mat3::Identity()}, narrow{Vec3::Zero(), Mat3::Identity() * 0.81};
  EXPECT_NEAR(*divergence(narrow, wide), 0.031082, 1e-6);
  EXPECT_NEAR(*divergence(wide, narrow), 0.035770, 1e-6);
  EXPECT_NEAR(*divergence(wide, wide), 0.0, 1e-12);
}

TEST(Divergence, OfAShift) {
  const Gaussian a{Vec3(1, 0, 0), Mat3::Identity()}, b{Vec3::Zero(), Mat3::Identity()};
  EXPECT_NEAR(*divergence(a, b), 0.5, 1e-12);
  EXPECT_FALSE(divergence(a, {Vec3::Zero(), Mat3::Zero()}));
}

TEST(FitGaussian, MeanAndSampleCovariance) {
  Points points(4, 3);
  points << 1, 0, 0, -1, 0, 0, 0, 2, 0, 0, -2, 0;
  const Gaussian g = fit_gaussian(points);
  EXPECT_NEAR(g.mean.norm(), 0.0, 1e-15);
  EXPECT_NEAR(g.covariance(0, 0), 2.0 / 3.0, 1e-15);
  EXPECT_NEAR(g.covariance(1, 1), 8.0 / 3.0, 1e-15);
  EXPECT_EQ(fit_gaussian(points.topRows(1)).covariance, Mat3(Mat3::Zero()));
}

TEST(UpdatePoints, GathersThePointsInTheBox) {
  base::Random random(3, "test", 0);
  Points points = generate_points(nadir(), {300, 300, 700, 700}, 5000, {18.0, 22.0}, BoxFill::uniform, random);
  const PixelBox box{520, 480, 580, 540};
  UpdateOptions options;
  options.noise_m = 0.01;
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(update_points(points, nadir(), box, options, random).updated);
  std::size_t inside = 0;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const auto p = nadir().project(points.row(i).transpose());
    inside += p && box.contains(*p) ? 1U : 0U;
  }
  EXPECT_GT(inside, 4000U);
}

// (A.3): with w1 = 1 the chance of a point is the Gaussian's density, half width = one sigma.
TEST(UpdatePoints, WeighsByTheGaussianOfTheBox) {
  const View view = nadir();
  const PixelBox box{400, 400, 600, 600};
  Points start(2, 3);
  // Depth 20 m, 0.02 m a pixel: a point at the centre and one at one sigma in u.
  start << 0, 0, 0, 2.0, 0, 0;
  UpdateOptions options;
  options.noise_m = 0.0;
  options.gaussian_weight = 1.0;
  options.uniform_weight = 0.0;
  options.systematic = false;
  base::Random random(4, "test", 0);
  double centre = 0.0;
  constexpr int kRuns = 20000;
  for (int i = 0; i < kRuns; ++i) {
    Points points = start;
    update_points(points, view, box, options, random);
    centre += (points(0, 0) == 0.0 ? 1 : 0) + (points(1, 0) == 0.0 ? 1 : 0);
  }
  const double expected = 1.0 / (1.0 + std::exp(-0.5));
  EXPECT_NEAR(centre / (2.0 * kRuns), expected, 5.0 * std::sqrt(0.25 / (2.0 * kRuns)));
}

TEST(UpdatePoints, MixesTheUniformDensityInside) {
  // One point inside at 0.9 sigma in both axes, one outside at 1.1: ratio of (A.3)'s two terms.
  const PixelBox box{400, 400, 600, 600};
  Points start(2, 3);
  start << 1.8, 1.8, 0, 2.2, 2.2, 0;
  UpdateOptions options;
  options.noise_m = 0.0;
  options.systematic = false;
  base::Random random(5, "test", 0);
  double inner = 0.0;
  constexpr int kRuns = 20000;
  for (int i = 0; i < kRuns; ++i) {
    Points points = start;
    update_points(points, nadir(), box, options, random);
    inner += (points(0, 0) == 1.8 ? 1 : 0) + (points(1, 0) == 1.8 ? 1 : 0);
  }
  const double g1 = 0.2 / (2.0 * M_PI * 1e4) * std::exp(-0.81) + 0.8 / 4e4;
  const double g2 = 0.2 / (2.0 * M_PI * 1e4) * std::exp(-1.21);
  EXPECT_NEAR(inner / (2.0 * kRuns), g1 / (g1 + g2), 5.0 * std::sqrt(0.25 / (2.0 * kRuns)));
}

TEST(UpdatePoints, TheLetterNeverMovesAPoint) {
  base::Random random(6, "test", 0);
  Points points = generate_points(nadir(), {450, 450, 550, 550}, 500, {18.0, 22.0}, BoxFill::corner_weights, random);
  std::set<double> before(points.col(0).begin(), points.col(0).end());
  UpdateOptions options;
  options.move_points = options.systematic = options.cheirality = false;
  std::size_t distinct = before.size();
  for (int i = 0; i < 4; ++i) {
    update_points(points, nadir(), {450, 450, 550, 550}, options, random);
    const std::set<double> after(points.col(0).begin(), points.col(0).end());
    for (const double x : after) ASSERT_TRUE(before.contains(x));
    EXPECT_LT(after.size(), distinct);
    distinct = after.size();
  }
}

TEST(UpdatePoints, LowVarianceDrawsKeepEqualWeightsWhole) {
  // All weights equal: systematic resampling must return every point once.
  Points points(7, 3);
  points.setZero();
  for (Eigen::Index i = 0; i < 7; ++i) points(i, 2) = 0.1 * static_cast<double>(i);
  UpdateOptions options;
  options.noise_m = 0.0;
  base::Random random(7, "test", 0);
  const Points before = points;
  ASSERT_TRUE(update_points(points, nadir(), {490, 490, 510, 510}, options, random).updated);
  EXPECT_TRUE(points == before);
}

TEST(UpdatePoints, AllBehindTheCameraLeavesThePoints) {
  Points points(100, 3);
  points.setConstant(50.0);  // above the camera that looks down from 20 m
  const Points before = points;
  base::Random random(8, "test", 0);
  const auto report = update_points(points, nadir(), {0, 0, 1000, 1000}, {}, random);
  EXPECT_FALSE(report.updated);
  EXPECT_EQ(report.behind, 100U);
  EXPECT_TRUE(points == before);
  // The letter does not test: the mirrored projection of such points counts.
  UpdateOptions letter;
  letter.cheirality = letter.move_points = letter.systematic = false;
  points.col(0).setZero();
  points.col(1).setZero();
  EXPECT_TRUE(update_points(points, nadir(), {0, 0, 1000, 1000}, letter, random).updated);
}

TEST(UpdatePoints, AllWeightsZeroLeavesThePoints) {
  base::Random random(9, "test", 0);
  Points points = generate_points(nadir(), {450, 450, 550, 550}, 100, {18, 22}, BoxFill::uniform, random);
  const Points before = points;
  EXPECT_FALSE(update_points(points, nadir(), {1e6, 1e6, 1e6 + 1, 1e6 + 1}, {}, random).updated);
  EXPECT_TRUE(points == before);
}

TEST(UpdatePoints, EmptyBoxesAndPointsAreNoUpdate) {
  base::Random random(10, "test", 0);
  Points points = generate_points(nadir(), {450, 450, 550, 550}, 10, {18, 22}, BoxFill::uniform, random);
  EXPECT_FALSE(update_points(points, nadir(), {500, 400, 500, 600}, {}, random).updated);
  EXPECT_FALSE(update_points(points, nadir(), {600, 600, 400, 400}, {}, random).updated);
  EXPECT_FALSE(update_points(points, nadir(), {std::nan(""), 0, 1, 1}, {}, random).updated);
  Points none(0, 3);
  EXPECT_FALSE(update_points(none, nadir(), {0, 0, 100, 100}, {}, random).updated);
  EXPECT_TRUE(points.allFinite());
}

}  // namespace
}  // namespace cairn::localisation
