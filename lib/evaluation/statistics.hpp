// Figures of samples, and intervals that say how sure they are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "base/random.hpp"

namespace cairn::evaluation {

// Quantile by linear interpolation between order statistics (Hyndman & Fan 1996, type 7). q in 0..1.
// Empty where there are no values.
[[nodiscard]] std::optional<double> quantile(std::vector<double> values, double q);

struct Spread {
  std::size_t count = 0;
  double mean = 0.0, rms = 0.0, median = 0.0, p95 = 0.0, max = 0.0;  // all 0 where count is 0
};
[[nodiscard]] Spread spread(const std::vector<double>& values);

struct Interval {
  double low = 0.0, high = 0.0;

  [[nodiscard]] bool contains(double value) const { return low <= value && value <= high; }
};

// 95 % interval of a proportion, hits of trials (Wilson 1927). trials = 0 gives 0..1.
[[nodiscard]] Interval wilson(std::size_t hits, std::size_t trials);

// 95 % percentile bootstrap (Efron 1979) of a figure over groups that are drawn with replacement, each with all its
// values: values of one group (a survey) hang together, groups do not. `figure` maps pooled values to a number.
// Empty where all groups are. Cost: draws * (sum of values + cost of figure).
[[nodiscard]] std::optional<Interval> bootstrap(const std::vector<std::vector<double>>& groups,
                                                const std::function<double(std::vector<double>)>& figure,
                                                base::Random& random, std::size_t draws = 1000);

// P(X <= x) of a chi-square variable with `freedom` > 0 degrees: the regularised lower incomplete gamma function
// P(freedom/2, x/2), by series or continued fraction (Abramowitz & Stegun 6.5.29, 6.5.31), to 1e-12.
[[nodiscard]] double chi_square_cdf(double x, double freedom);
// Its inverse, by bisection to 1e-10 relative. p in 0..1, both exclusive.
[[nodiscard]] double chi_square_quantile(double p, double freedom);

// Where the mean of `count` independent normalised errors squared lies with 95 % probability when the covariances are
// right: chi-square with 3 * count degrees over count (Bar-Shalom et al. 2001, 5.4). count >= 1.
[[nodiscard]] Interval mean_nees_band(std::size_t count);

}  // namespace cairn::evaluation
