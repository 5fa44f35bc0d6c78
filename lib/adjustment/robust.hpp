// Medians of small samples.
#pragma once

#include <vector>

namespace cairn::adjustment {

// Middle value (mean of the middle two where the count is even); infinite values sort last.
// 0 for an empty sample: ask empty() first. Cost n log n.
[[nodiscard]] double median(std::vector<double> values);

// 1.4826 * median(|v - median(v)|): the standard deviation of a normal sample, blind to outliers.
[[nodiscard]] double robust_sigma(const std::vector<double>& values);

}  // namespace cairn::adjustment
