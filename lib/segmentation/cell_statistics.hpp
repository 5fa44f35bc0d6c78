// Heights of the points in each cell of a grid.
#pragma once

#include <cstdint>
#include <span>

#include "geometry/grid.hpp"
#include "geometry/vec.hpp"

namespace cairn::segmentation {

// Two lowest and two highest: enough to tell a surface from one stray point.
struct CellHeights {
  float low = 0.0F, second_low = 0.0F;  // m; equal to low with one point
  float high = 0.0F, second_high = 0.0F;
  std::uint32_t points = 0;
};

struct CellStatistics {
  geometry::Grid<float> max, mean;  // m; NaN where a cell has no point
  geometry::Grid<std::uint32_t> count;
  std::size_t outside = 0;  // points outside the grid or not finite
};

// One pass over the points, linear; mean summed in double. About 20 ns a point where the order is random.
[[nodiscard]] CellStatistics cell_statistics(std::span<const geometry::Vec3> points,
                                             const geometry::GridGeometry& geometry);

// The same for the extremes. outside: set to the number of points left out.
[[nodiscard]] geometry::Grid<CellHeights> cell_heights(std::span<const geometry::Vec3> points,
                                                       const geometry::GridGeometry& geometry, std::size_t& outside);

}  // namespace cairn::segmentation
