#include "evaluation/statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace cairn::evaluation {
namespace {

TEST(Quantile, InterpolatesBetweenOrderStatistics) {
  EXPECT_FALSE(quantile({}, 0.5).has_value());
  EXPECT_DOUBLE_EQ(*quantile({3.0}, 0.95), 3.0);
  EXPECT_DOUBLE_EQ(*quantile({4.0, 1.0, 2.0, 3.0}, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(*quantile({0.0, 10.0}, 0.95), 9.5);
  EXPECT_DOUBLE_EQ(*quantile({0.0, 10.0}, 1.0), 10.0);
}

TEST(Spread, OfThreeNumbers) {
  const Spread s = spread({1.0, 2.0, 6.0});
  EXPECT_EQ(s.count, 3U);
  EXPECT_DOUBLE_EQ(s.mean, 3.0);
  EXPECT_DOUBLE_EQ(s.rms, std::sqrt(41.0 / 3.0));
  EXPECT_DOUBLE_EQ(s.median, 2.0);
  EXPECT_DOUBLE_EQ(s.max, 6.0);
}

// Newcombe (1998), Statistics in Medicine 17:857, table I: method 3 for 81/263, 15/148, 0/20, 1/29.
TEST(Wilson, PublishedIntervals) {
  constexpr double kPrinted = 5e-5;  // four decimals are printed
  const auto check = [](std::size_t hits, std::size_t trials, double low, double high) {
    const Interval i = wilson(hits, trials);
    EXPECT_NEAR(i.low, low, kPrinted);
    EXPECT_NEAR(i.high, high, kPrinted);
  };
  check(81, 263, 0.2553, 0.3662);
  check(15, 148, 0.0624, 0.1605);
  check(0, 20, 0.0000, 0.1611);
  check(1, 29, 0.0061, 0.1718);
  EXPECT_DOUBLE_EQ(wilson(0, 0).high, 1.0);
}

// Abramowitz & Stegun, table 26.8.
TEST(ChiSquare, PublishedQuantiles) {
  constexpr double kPrinted = 5e-4;
  EXPECT_NEAR(chi_square_quantile(0.95, 1.0), 3.84146, kPrinted);
  EXPECT_NEAR(chi_square_quantile(0.95, 3.0), 7.81473, kPrinted);
  EXPECT_NEAR(chi_square_quantile(0.025, 3.0), 0.215795, kPrinted);
  EXPECT_NEAR(chi_square_quantile(0.975, 30.0), 46.9792, kPrinted);
  EXPECT_NEAR(chi_square_quantile(0.025, 100.0), 74.2219, kPrinted);
  EXPECT_NEAR(chi_square_quantile(0.975, 100.0), 129.561, kPrinted);
}

TEST(ChiSquare, TwoDegreesAreAnExponential) {
  for (const double x : {0.01, 0.5, 2.0, 3.9, 4.1, 20.0, 60.0})
    EXPECT_NEAR(chi_square_cdf(x, 2.0), 1.0 - std::exp(-0.5 * x), 1e-13) << x;
  for (const double freedom : {1.0, 3.0, 300.0, 3000.0})
    EXPECT_NEAR(chi_square_cdf(chi_square_quantile(0.3, freedom), freedom), 0.3, 1e-9);
}

TEST(MeanNees, BandOfOneHundred) {
  const Interval band = mean_nees_band(100);
  // 300 degrees: quantiles 253.912 and 349.874 (scipy.stats.chi2.ppf).
  EXPECT_NEAR(band.low, 2.53912, 5e-5);
  EXPECT_NEAR(band.high, 3.49874, 5e-5);
}

TEST(Bootstrap, CoversTheMeanAndGrowsWithDependence) {
  const auto mean = [](const std::vector<double>& values) { return spread(values).mean; };
  std::vector<std::vector<double>> apart, together;
  base::Random draw(7, "values", 0);
  for (int g = 0; g < 50; ++g) {
    const double shared = draw.normal();
    apart.push_back({draw.normal(), draw.normal(), draw.normal(), draw.normal()});
    together.push_back({shared, shared, shared, shared});
  }
  base::Random first(1, "bootstrap", 0), again(1, "bootstrap", 0), other(1, "bootstrap", 1);
  const auto narrow = bootstrap(apart, mean, first), same = bootstrap(apart, mean, again);
  const auto wide = bootstrap(together, mean, other);
  ASSERT_TRUE(narrow && wide && same);
  EXPECT_EQ(narrow->low, same->low);
  // Standard errors 1/sqrt(200) and 1/sqrt(50): the second is twice the first.
  EXPECT_GT(wide->high - wide->low, 1.5 * (narrow->high - narrow->low));
  EXPECT_NEAR(narrow->high - narrow->low, 2 * 1.96 / std::sqrt(200.0), 0.08);
  EXPECT_FALSE(bootstrap({{}, {}}, mean, first).has_value());
}

}  // namespace
}  // namespace cairn::evaluation
