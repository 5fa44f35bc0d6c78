#include "segmentation/terrain.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "base/parallel.hpp"
#include "segmentation/cell_statistics.hpp"
#include "segmentation/grid_fill.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Grid;
using geometry::GridGeometry;
using geometry::Vec2;
using geometry::Vec3;

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr double kMostCells = 4e8;

GridGeometry geometry_of(std::span<const Vec3> points, double cell) {
  Vec2 lo = Vec2::Constant(std::numeric_limits<double>::infinity()), hi = -lo;
  for (const Vec3& p : points) {
    if (!p.allFinite()) continue;
    lo = lo.cwiseMin(p.head<2>());
    hi = hi.cwiseMax(p.head<2>());
  }
  if (!(lo.x() <= hi.x()))
    throw base::Error(base::ErrorCode::invalid_input, "the cloud has no finite point")
        .hint("Check the cloud with `cairn info`.");
  const double cells = ((hi.x() - lo.x()) / cell + 1.0) * ((hi.y() - lo.y()) / cell + 1.0);
  if (!(cells <= kMostCells))
    throw base::Error(base::ErrorCode::failed_precondition, "the cloud's extent needs too many cells")
        .found(base::to_text(hi.x() - lo.x()) + " x " + base::to_text(hi.y() - lo.y()) + " m in cells of " +
               base::to_text(cell) + " m")
        .allowed("400 million cells")
        .hint("Use a larger --cell-m, or remove stray points far from the survey.");
  // Cells own their western and northern border: the easternmost and southernmost points need room.
  const double nudge = 1e-6 * cell;
  return geometry::covering_grid(lo - Vec2(0.0, nudge), hi + Vec2(nudge, 0.0), cell);
}

// Extremes that one stray point cannot move. sign = 1 for the highest, -1 for the lowest points.
struct Guarded {
  Grid<float> height;  // NaN where unobserved
  std::size_t spikes = 0;
};

Guarded guarded_extreme(const Grid<CellHeights>& cells, double spike_m, bool highest) {
  const GridGeometry& g = cells.geometry;
  const auto first = [highest](const CellHeights& c) { return highest ? c.high : -c.low; };
  const auto second = [highest](const CellHeights& c) { return highest ? c.second_high : -c.second_low; };
  const auto spike = static_cast<float>(spike_m);
  Guarded result{Grid<float>(g, kNone), 0};
  std::vector<std::size_t> spikes_in_row(g.rows, 0);
  base::parallel_for(g.rows, 32, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r)
      for (std::size_t c = 0; c < g.columns; ++c) {
        const CellHeights& cell = cells.at(r, c);
        if (cell.points == 0) continue;
        float value = first(cell);
        const bool alone = cell.points == 1;
        if (alone || value - second(cell) > spike) {
          float around = -std::numeric_limits<float>::infinity();
          for (std::size_t i = r - (r > 0 ? 1U : 0U); i <= std::min(r + 1, g.rows - 1); ++i)
            for (std::size_t j = c - (c > 0 ? 1U : 0U); j <= std::min(c + 1, g.columns - 1); ++j)
              if ((i != r || j != c) && cells.at(i, j).points > 0) around = std::max(around, first(cells.at(i, j)));
          // Without neighbours there is nothing to compare with; the point is believed.
          if (std::isfinite(around) && value - around > spike) {
            ++spikes_in_row[r];
            value = alone ? kNone : second(cell);
          }
        }
        result.height.at(r, c) = highest ? value : -value;
      }
  });
  for (const std::size_t n : spikes_in_row) result.spikes += n;
  return result;
}

// Heights with a border of `width` cells, reflected at the edge's height so that a slope goes on: a flat window
// that met the edge would cut off its uphill side.
Grid<float> with_border(const Grid<float>& inner, std::size_t width) {
  const GridGeometry& g = inner.geometry;
  Grid<float> outer({g.west, g.north, g.cell, g.columns + 2 * width, g.rows + 2 * width}, 0.0F);
  // Place of index i - width in 0..count-1, and whether it lies beyond an edge and which.
  const auto place = [width](std::size_t i, std::size_t count) {
    const auto last = static_cast<std::ptrdiff_t>(count) - 1;
    const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(i) - static_cast<std::ptrdiff_t>(width);
    const std::ptrdiff_t edge = std::clamp<std::ptrdiff_t>(at, 0, last);
    const std::ptrdiff_t mirror = std::clamp<std::ptrdiff_t>(2 * edge - at, 0, last);
    return std::pair(static_cast<std::size_t>(edge), static_cast<std::size_t>(mirror));
  };
  for (std::size_t r = 0; r < outer.geometry.rows; ++r) {
    const auto [edge_row, row] = place(r, g.rows);
    for (std::size_t c = 0; c < outer.geometry.columns; ++c) {
      const auto [edge_column, column] = place(c, g.columns);
      outer.at(r, c) = edge_row == row && edge_column == column
                           ? inner.at(row, column)
                           : 2.0F * inner.at(edge_row, edge_column) - inner.at(row, column);
    }
  }
  return outer;
}

// Ground cells by progressive opening of the lowest heights (complete, no NaN).
Grid<std::uint8_t> ground_cells(const Grid<float>& lowest, const TerrainOptions& options) {
  const GridGeometry& g = lowest.geometry;
  const auto widest = static_cast<std::size_t>(std::ceil(options.max_object_m / options.cell_m / 2.0));
  Grid<float> current = with_border(lowest, widest);
  Grid<std::uint8_t> object(current.geometry, 0);
  std::size_t previous = 0;
  for (std::size_t radius = 1; previous < widest; radius *= 2) {
    radius = std::min(radius, widest);
    Grid<float> opening = opened(current, radius);
    const double growth = 2.0 * static_cast<double>(radius - previous) * options.cell_m;
    const auto step =
        static_cast<float>(std::min(options.ground_tolerance_m + options.ground_slope * growth, options.max_step_m));
    base::parallel_for(object.values.size(), 65536, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k)
        if (current.values[k] - opening.values[k] > step) object.values[k] = 1;
    });
    current = std::move(opening);
    previous = radius;
  }
  // The feet of an object are too low to be told from ground; a cell around it goes with it.
  Grid<std::uint8_t> ground(g, 1);
  for (std::size_t r = 0; r < g.rows; ++r)
    for (std::size_t c = 0; c < g.columns; ++c)
      for (std::size_t i = r - (r > 0 ? 1U : 0U); i <= std::min(r + 1, g.rows - 1); ++i)
        for (std::size_t j = c - (c > 0 ? 1U : 0U); j <= std::min(c + 1, g.columns - 1); ++j)
          if (object.at(i + widest, j + widest) != 0) ground.at(r, c) = 0;
  return ground;
}

}  // namespace

TerrainModel model_terrain(std::span<const Vec3> points, const TerrainOptions& options, base::RunContext& ctx) {
  TerrainOptions checked = options;
  base::validate(base::bind_options(checked), "terrain");
  const GridGeometry geometry = geometry_of(points, options.cell_m);
  ctx.check_memory(60 * static_cast<std::uint64_t>(geometry.cells()), "terrain grids");

  TerrainModel model;
  const Grid<CellHeights> cells = cell_heights(points, geometry, model.not_finite);
  model.points = {geometry, 0};
  for (std::size_t k = 0; k < cells.values.size(); ++k) model.points.values[k] = cells.values[k].points;
  ctx.check_stop();

  Guarded top = guarded_extreme(cells, options.spike_m, true);
  Guarded low = guarded_extreme(cells, options.spike_m, false);
  model.spikes = top.spikes;
  model.observed = {geometry, 0};
  for (std::size_t k = 0; k < top.height.values.size(); ++k)
    model.observed.values[k] = std::isfinite(top.height.values[k]) ? 1 : 0;
  const auto reach = static_cast<std::size_t>(std::floor(options.max_gap_m / options.cell_m / 2.0 + 1e-9));
  const Grid<std::uint8_t> known = closed_mask(model.observed, reach);
  ctx.check_stop();

  model.surface = std::move(top.height);
  fill_all(model.surface);
  Grid<float> lowest = low.height;
  fill_all(lowest);
  const Grid<std::uint8_t> ground = ground_cells(lowest, options);
  ctx.check_stop();
  model.ground = std::move(low.height);
  for (std::size_t k = 0; k < ground.values.size(); ++k)
    if (ground.values[k] == 0) model.ground.values[k] = kNone;
  fill_all(model.ground);
  for (std::size_t k = 0; k < known.values.size(); ++k) {
    if (known.values[k] == 0) {
      model.surface.values[k] = model.ground.values[k] = kNone;
      continue;
    }
    // Where no cell at all is ground, the lowest points are the best there is.
    if (!std::isfinite(model.ground.values[k])) model.ground.values[k] = lowest.values[k];
    model.ground.values[k] = std::min(model.ground.values[k], model.surface.values[k]);
    model.interpolated += model.observed.values[k] == 0 ? 1U : 0U;
  }
  return model;
}

}  // namespace cairn::segmentation
