#include "localisation/normal_draws.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace cairn::localisation {
namespace {

std::vector<double> draws(std::size_t count) {
  std::vector<double> values(count);
  base::Random random(11, "test", 0);
  fill_normal(values, random);
  return values;
}

TEST(NormalDraws, FollowTheNormalDistribution) {
  auto values = draws(1000000);
  std::sort(values.begin(), values.end());
  const auto n = static_cast<double>(values.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i)
    largest = std::max(largest, std::abs((static_cast<double>(i) + 0.5) / n - 0.5 * std::erfc(-values[i] / M_SQRT2)));
  // Kolmogorov-Smirnov: passed with probability 1e-6 only by a sound generator's bad luck.
  EXPECT_LT(largest, 2.7 / std::sqrt(n));
}

TEST(NormalDraws, ReachIntoTheTail) {
  const auto values = draws(4000000);
  const auto beyond = [&](double x) {
    return static_cast<double>(std::count_if(values.begin(), values.end(), [x](double v) { return std::abs(v) > x; }));
  };
  // Beyond the ziggurat's base layer (3.654) and further: expected counts, five standard deviations.
  for (const double x : {3.0, 3.7, 4.2}) {
    const double expected = 4e6 * std::erfc(x / M_SQRT2);
    EXPECT_NEAR(beyond(x), expected, 5.0 * std::sqrt(expected)) << x;
  }
}

TEST(NormalDraws, AreTheSameForTheSameKey) {
  EXPECT_EQ(draws(1000), draws(1000));
}

}  // namespace
}  // namespace cairn::localisation
