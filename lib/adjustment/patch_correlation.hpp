// Where a patch lies within a larger search window.
#pragma once

#include <optional>
#include <vector>

#include "geometry/vec.hpp"

namespace cairn::adjustment {

// Square windows, row-major from the north; NaN = no value.
struct Window {
  std::size_t side = 0;
  std::vector<float> values;  // side * side
};

struct PatchPeak {
  geometry::Vec2 shift_cells = geometry::Vec2::Zero();  // column, row by which the patch is moved against the window
  double correlation = 0.0;                             // -1..1
};

// Normalised cross-correlation of `patch` with every position inside `window` (both share their centre;
// window.side - patch.side is even), over the cells where both have values. Peak refined by a
// quadric through its 3 x 3 scores. Empty when the peak lies on the border of the search, when fewer than 80 % of the
// cells have values at the peak, or when one side has no contrast. Cost: patch.side^2 * (window.side - patch.side +
// 1)^2.
[[nodiscard]] std::optional<PatchPeak> correlate(const Window& patch, const Window& window);

}  // namespace cairn::adjustment
