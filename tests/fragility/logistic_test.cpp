#include "fragility/logistic.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.hpp"
#include "base/random.hpp"

namespace cairn::fragility {
namespace {

std::vector<ShakeOutcome> drawn(std::size_t count, const std::array<double, 3>& b, std::size_t records = 20) {
  std::vector<ShakeOutcome> list;
  base::Random random(1, "logistic", count);
  for (std::size_t i = 0; i < count; ++i) {
    const double pga = std::exp(random.uniform(-3.0, 0.5)), ratio = std::exp(random.uniform(-4.0, -1.5));
    const double p = 1.0 / (1.0 + std::exp(-(b[0] + b[1] * std::log(pga) + b[2] * std::log(ratio))));
    list.push_back({pga, ratio, random.uniform() < p, i % records});
  }
  return list;
}

TEST(Logistic, FindsTheCoefficientsOfManyOutcomes) {
  const std::array<double, 3> b = {18.0, 4.5, 4.0};
  for (const bool firth : {false, true}) {
    const auto fit = fit_logistic(drawn(40000, b), {firth, true});
    ASSERT_TRUE(fit.fitted);
    EXPECT_FALSE(fit.separable);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(fit.b[k], b[k], 0.05 * std::abs(b[k]));
    EXPECT_NEAR(fit.probability(fit.median_pga_g(0.1), 0.1), 0.5, 1e-12);
  }
}

// Maximum likelihood by hand: two points of 1/4 and 3/4 give the logits -ln 3 and ln 3.
TEST(Logistic, TwoGroupsByHand) {
  std::vector<ShakeOutcome> list;
  for (int i = 0; i < 4; ++i) {
    list.push_back({1.0, 0.1, i == 0, 0});
    list.push_back({std::exp(1.0), 0.1, i != 0, 0});
  }
  const auto fit = fit_logistic(list, {false, true});
  ASSERT_TRUE(fit.fitted);
  EXPECT_FALSE(fit.with_ratio);  // one ratio: no second term
  EXPECT_NEAR(fit.b[0], -std::log(3.0), 1e-9);
  EXPECT_NEAR(fit.b[1], 2.0 * std::log(3.0), 1e-9);
}

// Firth's estimate for one group of k of n: logit of (k + 1/2) / (n + 1) at its mean.
TEST(Logistic, SeparableOutcomesStayFinite) {
  std::vector<ShakeOutcome> list;
  for (int i = 0; i < 10; ++i) {
    list.push_back({0.1 + 0.01 * i, 0.1, false, 0});
    list.push_back({0.5 + 0.01 * i, 0.1, true, 1});
  }
  const auto likelihood = fit_logistic(list, {false, true});
  EXPECT_FALSE(likelihood.fitted);
  EXPECT_EQ(likelihood.reason, "separable");
  const auto firth = fit_logistic(list, {true, true});
  ASSERT_TRUE(firth.fitted);
  EXPECT_TRUE(firth.separable);
  EXPECT_GT(firth.b[1], 0.0);
  EXPECT_LT(firth.b[1], 20.0);
  EXPECT_GT(firth.median_pga_g(0.1), 0.19);
  EXPECT_LT(firth.median_pga_g(0.1), 0.5);
}

TEST(Logistic, AllOrNoneHaveNoCurve) {
  std::vector<ShakeOutcome> list = {{0.1, 0.1, true, 0}, {0.2, 0.1, true, 1}};
  EXPECT_EQ(fit_logistic(list).reason, "all_toppled");
  for (auto& o : list) o.toppled = false;
  EXPECT_EQ(fit_logistic(list).reason, "none_toppled");
  EXPECT_EQ(fit_logistic({}).reason, "no_outcomes");
  list[0].pga_g = 0.0;
  EXPECT_THROW((void)fit_logistic(list), base::Error);
}

TEST(Logistic, BandHoldsTheTruthAndRepeats) {
  const std::array<double, 3> b = {18.0, 4.5, 4.0};
  const auto list = drawn(600, b, 30);
  const LogisticOptions options;
  const auto fit = fit_logistic(list, options);
  const std::vector<std::array<double, 2>> at = {{0.3, 0.1}, {0.2, 0.1}, {0.5, 0.05}};
  const auto band = bootstrap_curve(list, fit, options, at, 200, 7);
  for (const auto& point : band) {
    const double truth =
        1.0 / (1.0 + std::exp(-(b[0] + b[1] * std::log(point.pga_g) + b[2] * std::log(point.pgv_over_pga_s))));
    EXPECT_LE(point.p05, point.p16);
    EXPECT_LE(point.p84, point.p95);
    EXPECT_LT(point.p05, truth + 0.02);
    EXPECT_GT(point.p95, truth - 0.02);
    EXPECT_LT(point.p95 - point.p05, 0.4);
  }
  const auto again = bootstrap_curve(list, fit, options, at, 200, 7);
  EXPECT_EQ(band[0].p05, again[0].p05);
  auto one_record = list;
  for (auto& o : one_record) o.record = 3;
  EXPECT_THROW((void)bootstrap_curve(one_record, fit, options, at, 200, 7), base::Error);
}

TEST(Logistic, Brier) {
  const std::vector<ShakeOutcome> list = {{1, 1, true, 0}, {1, 1, false, 0}};
  EXPECT_DOUBLE_EQ(brier_score(std::vector<double>{0.75, 0.5}, list), 0.5 * (0.0625 + 0.25));
}

}  // namespace
}  // namespace cairn::fragility
