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
constexpr std::size_t kReach = 4;  // cells: roughness is a mean over 9 x 9
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

// Mean of values over the cells within kReach rows and columns where weight is 1; 0 where there is none.
void box_mean(std::vector<float>& values, std::vector<float>& weights, const GridGeometry& g) {
  const auto sums = [&](std::vector<float>& v) {
    base::parallel_for(g.rows, kRows, [&](std::size_t begin, std::size_t end) {
      std::vector<float> line(g.columns + 2 * kReach, 0.0F);
      for (std::size_t r = begin; r < end; ++r) {
        float* row = v.data() + r * g.columns;
        std::copy_n(row, g.columns, line.begin() + kReach);
        std::fill_n(row, g.columns, 0.0F);
        for (std::size_t j = 0; j <= 2 * kReach; ++j)
          for (std::size_t c = 0; c < g.columns; ++c) row[c] += line[c + j];
      }
    });
    const std::vector<float> rows = v;
    base::parallel_for(g.rows, kRows, [&](std::size_t begin, std::size_t end) {
      for (std::size_t r = begin; r < end; ++r) {
        float* row = v.data() + r * g.columns;
        std::fill_n(row, g.columns, 0.0F);
        for (std::size_t i = r > kReach ? r - kReach : 0; i <= std::min(r + kReach, g.rows - 1); ++i)
          for (std::size_t c = 0; c < g.columns; ++c) row[c] += rows[i * g.columns + c];
      }
    });
  };
  sums(values);
  sums(weights);
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = weights[k] > 0.0F ? values[k] / weights[k] : 0.0F;
}

// Standard deviation of the ground's points about a smooth surface, from second differences of the lowest points of
// three ground cells in a row or column: such a difference of independent heights of deviation s has sqrt(6) s, and the
// lowest of a few points scatters by about 0.65 of what one point does.
std::vector<float> roughness(const Grid<std::uint8_t>& is_ground, const Grid<float>& low) {
  const GridGeometry& g = low.geometry;
  std::vector<float> squares(g.cells(), 0.0F), weights(g.cells(), 0.0F);
  for_each_cell(g, [&](std::size_t r, std::size_t c, std::size_t k) {
    if (is_ground.values[k] == 0) return;
    const auto take = [&](bool inside, std::size_t step) {
      if (!inside || is_ground.values[k - step] == 0 || is_ground.values[k + step] == 0) return;
      const float d = low.values[k - step] - 2.0F * low.values[k] + low.values[k + step];
      squares[k] += d * d;
      weights[k] += 1.0F;
    };
    take(c > 0 && c + 1 < g.columns, 1);
    take(r > 0 && r + 1 < g.rows, g.columns);
  });
  box_mean(squares, weights, g);
  constexpr float kPerSquare = 1.0F / (6.0F * 0.65F * 0.65F);
  for (float& s : squares) s = std::sqrt(s * kPerSquare);
  return squares;
}

Grid<float> tolerances(const GroundSurface& surface, const Grid<float>& low, float level,
                       const GroundFilterOptions& options) {
  const GridGeometry& g = low.geometry;
  Grid<float> result(g, level);
  const std::vector<float> rough = roughness(surface.is_ground, low);
  const auto slope_factor = static_cast<float>(options.tolerance_slope);
  const auto rough_factor = static_cast<float>(options.roughness_factor);
  for_each_cell(g, [&](std::size_t r, std::size_t c, std::size_t k) {
    const auto difference = [&](std::size_t i, std::size_t count, std::size_t step) {
      const std::size_t ahead = i + 1 < count ? step : 0, behind = i > 0 ? step : 0;
      const float steps = (ahead > 0 ? 1.0F : 0.0F) + (behind > 0 ? 1.0F : 0.0F);
      return steps > 0.0F ? (surface.height.values[k + ahead] - surface.height.values[k - behind]) / steps : 0.0F;
    };
    // Differences are per cell: cell times slope.
    const float dx = difference(c, g.columns, 1), dy = difference(r, g.rows, g.columns);
    result.values[k] = level + slope_factor * std::sqrt(dx * dx + dy * dy) + rough_factor * rough[k];
  });
  return result;
}

}  // namespace

GroundSurface bare_earth(const Grid<LowCell>& cells, const GroundFilterOptions& options) {
  const GridGeometry& g = cells.geometry;
  const auto tolerance =
      static_cast<float>(options.tolerance_m > 0.0 ? options.tolerance_m : options.tolerance_cells * g.cell);
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

  surface.tolerance = tolerances(surface, low, tolerance, options);
  return surface;
}

}  // namespace cairn::segmentation
