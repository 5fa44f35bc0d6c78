#include "segmentation/bare_earth.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.hpp"
#include "segmentation/grid_fill.hpp"
#include "segmentation/progressive_opening.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Grid;
using geometry::GridGeometry;

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr std::size_t kRows = 32;
constexpr double kPitSlope = 5.0;  // a cell lower than all neighbours by more than this times the cell is a stray point

// Calls use(r, c, k) for each cell, rows in parallel.
template <typename Use>
void for_each_cell(const GridGeometry& g, Use use) {
  base::parallel_for(g.rows, kRows, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r)
      for (std::size_t c = 0; c < g.columns; ++c) use(r, c, r * g.columns + c);
  });
}

// Lowest points, NaN where there are none or where they lie in a pit of one cell.
Grid<float> lowest(const Grid<LowCell>& cells) {
  const GridGeometry& g = cells.geometry;
  Grid<float> result(g, kNone);
  const auto deep = static_cast<float>(kPitSlope * g.cell);
  for_each_cell(g, [&](std::size_t r, std::size_t c, std::size_t k) {
    const LowCell& cell = cells.values[k];
    if (cell.points == 0) return;
    float around = std::numeric_limits<float>::infinity();
    for (std::size_t i = r - (r > 0 ? 1U : 0U); i <= std::min(r + 1, g.rows - 1); ++i)
      for (std::size_t j = c - (c > 0 ? 1U : 0U); j <= std::min(c + 1, g.columns - 1); ++j)
        if (i != r || j != c) around = std::min(around, cells.at(i, j).low);
    if (std::isfinite(around) && around - cell.low > deep) return;
    result.values[k] = cell.low;
  });
  return result;
}

}  // namespace

GroundSurface bare_earth(const Grid<LowCell>& cells, const GroundFilterOptions& options) {
  const GridGeometry& g = cells.geometry;
  const auto tolerance = static_cast<float>(options.tolerance_m > 0.0 ? options.tolerance_m : 0.5 * g.cell);
  Grid<float> low = lowest(cells);
  GroundSurface surface;
  surface.is_ground = {g, 0};
  for_each_cell(g, [&](std::size_t, std::size_t, std::size_t k) {
    surface.is_ground.values[k] = std::isfinite(low.values[k]) ? 1 : 0;
  });
  fill_all(low);
  const auto radius = static_cast<std::size_t>(std::ceil(0.5 * options.max_object_m / g.cell - 1e-9));
  const Grid<std::uint8_t> object = object_cells(low, radius, options.object_slope);

  // The lowest of n points of a sloping, noisy cell lies below its middle: where a cell holds nothing but ground, its
  // mean is the better height.
  surface.height = {g, kNone};
  for_each_cell(g, [&](std::size_t, std::size_t, std::size_t k) {
    if (object.values[k] != 0) surface.is_ground.values[k] = 0;
    if (surface.is_ground.values[k] == 0) return;
    const LowCell& cell = cells.values[k];
    const auto mean = static_cast<float>(cell.sum / cell.points);
    surface.height.values[k] = mean - cell.low < tolerance ? mean : cell.low;
  });
  fill_all(surface.height);
  // No ground at all: the lowest points are the best there is.
  for_each_cell(g, [&](std::size_t, std::size_t, std::size_t k) {
    if (!std::isfinite(surface.height.values[k])) surface.height.values[k] = low.values[k];
  });

  surface.tolerance = {g, tolerance};
  const auto slope_factor = static_cast<float>(options.tolerance_slope);
  for_each_cell(g, [&](std::size_t r, std::size_t c, std::size_t k) {
    const auto difference = [&](std::size_t i, std::size_t count, std::size_t step) {
      const std::size_t ahead = i + 1 < count ? step : 0, behind = i > 0 ? step : 0;
      const float steps = (ahead > 0 ? 1.0F : 0.0F) + (behind > 0 ? 1.0F : 0.0F);
      return steps > 0.0F ? (surface.height.values[k + ahead] - surface.height.values[k - behind]) / steps : 0.0F;
    };
    // Differences are per cell: cell times slope.
    const float dx = difference(c, g.columns, 1), dy = difference(r, g.rows, g.columns);
    surface.tolerance.values[k] = tolerance + slope_factor * std::sqrt(dx * dx + dy * dy);
  });
  return surface;
}

}  // namespace cairn::segmentation
