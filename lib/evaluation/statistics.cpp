#include "evaluation/statistics.hpp"

#include <algorithm>
#include <cmath>

namespace cairn::evaluation {

std::optional<double> quantile(std::vector<double> values, double q) {
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  const double at = std::clamp(q, 0.0, 1.0) * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (at - static_cast<double>(below)) * (values[above] - values[below]);
}

Spread spread(const std::vector<double>& values) {
  Spread s;
  s.count = values.size();
  if (values.empty()) return s;
  double sum = 0.0, squares = 0.0;
  for (const double v : values) {
    sum += v;
    squares += v * v;
    s.max = std::max(s.max, v);
  }
  const auto n = static_cast<double>(values.size());
  s.mean = sum / n;
  s.rms = std::sqrt(squares / n);
  s.median = *quantile(values, 0.5);
  s.p95 = *quantile(values, 0.95);
  return s;
}

Interval wilson(std::size_t hits, std::size_t trials) {
  if (trials == 0) return {0.0, 1.0};
  constexpr double kZ = 1.959963984540054;  // 97.5 % of the standard normal
  const auto n = static_cast<double>(trials);
  const double p = static_cast<double>(hits) / n;
  const double scale = 1.0 / (1.0 + kZ * kZ / n);
  const double centre = scale * (p + kZ * kZ / (2.0 * n));
  const double half = scale * kZ * std::sqrt(p * (1.0 - p) / n + kZ * kZ / (4.0 * n * n));
  return {std::max(0.0, centre - half), std::min(1.0, centre + half)};
}

std::optional<Interval> bootstrap(const std::vector<std::vector<double>>& groups,
                                  const std::function<double(std::vector<double>)>& figure, base::Random& random,
                                  std::size_t draws) {
  if (std::all_of(groups.begin(), groups.end(), [](const auto& g) { return g.empty(); })) return std::nullopt;
  std::vector<double> figures;
  while (figures.size() < draws) {
    std::vector<double> pooled;
    for (std::size_t i = 0; i < groups.size(); ++i) {
      const auto& group = groups[random.below(groups.size())];
      pooled.insert(pooled.end(), group.begin(), group.end());
    }
    if (!pooled.empty()) figures.push_back(figure(std::move(pooled)));
  }
  return Interval{*quantile(figures, 0.025), *quantile(figures, 0.975)};
}

double chi_square_cdf(double x, double freedom) {
  if (!(x > 0.0)) return 0.0;
  const double a = 0.5 * freedom, z = 0.5 * x;
  constexpr double kEnough = 1e-16;
  constexpr int kMost = 100000;
  const double front = std::exp(a * std::log(z) - z - std::lgamma(a));
  if (z < a + 1.0) {
    double term = 1.0 / a, sum = term;
    for (int n = 1; n < kMost && term > kEnough * sum; ++n) {
      term *= z / (a + n);
      sum += term;
    }
    return std::min(1.0, front * sum);
  }
  // Lentz's evaluation of the continued fraction of the upper function.
  constexpr double kTiny = 1e-300;
  double b = z + 1.0 - a, c = 1.0 / kTiny, d = 1.0 / b, h = d;
  for (int n = 1; n < kMost; ++n) {
    const double an = -n * (n - a);
    b += 2.0;
    d = an * d + b;
    if (std::abs(d) < kTiny) d = kTiny;
    c = b + an / c;
    if (std::abs(c) < kTiny) c = kTiny;
    d = 1.0 / d;
    const double factor = d * c;
    h *= factor;
    if (std::abs(factor - 1.0) < kEnough) break;
  }
  return std::clamp(1.0 - front * h, 0.0, 1.0);
}

double chi_square_quantile(double p, double freedom) {
  double low = 0.0, high = freedom + 10.0;
  while (chi_square_cdf(high, freedom) < p) high *= 2.0;
  while (high - low > 1e-10 * high) {
    const double middle = 0.5 * (low + high);
    (chi_square_cdf(middle, freedom) < p ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

Interval mean_nees_band(std::size_t count) {
  const auto n = static_cast<double>(count);
  return {chi_square_quantile(0.025, 3.0 * n) / n, chi_square_quantile(0.975, 3.0 * n) / n};
}

}  // namespace cairn::evaluation
