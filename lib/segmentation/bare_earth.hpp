// The ground grid from the lowest points of each cell; see ground_filter.hpp.
#pragma once

#include <cstdint>
#include <limits>

#include "geometry/grid.hpp"
#include "segmentation/ground_filter.hpp"

namespace cairn::segmentation {

struct LowCell {
  double sum = 0.0;  // of heights, m
  float low = std::numeric_limits<float>::infinity();
  std::uint32_t points = 0;
};

// Steps 1 to 4 of filter_ground, on the grid. Cost linear in cells.
[[nodiscard]] GroundSurface bare_earth(const geometry::Grid<LowCell>& cells, const GroundFilterOptions& options);

}  // namespace cairn::segmentation
