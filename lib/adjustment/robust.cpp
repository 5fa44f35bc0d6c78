#include "adjustment/robust.hpp"

#include <algorithm>
#include <cmath>

namespace cairn::adjustment {

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  if (values.size() % 2 == 1) return values[half];
  return 0.5 * (values[half - 1] + values[half]);
}

double robust_sigma(const std::vector<double>& values) {
  constexpr double kNormal = 1.4826;  // 1 / quantile(0.75) of the normal distribution
  const double middle = median(values);
  std::vector<double> deviations;
  deviations.reserve(values.size());
  for (const double v : values) deviations.push_back(std::abs(v - middle));
  return kNormal * median(std::move(deviations));
}

}  // namespace cairn::adjustment
