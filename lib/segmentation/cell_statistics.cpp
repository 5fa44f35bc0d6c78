#include "segmentation/cell_statistics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace cairn::segmentation {
namespace {

using geometry::GridGeometry;
using geometry::Vec3;

constexpr std::size_t kBlock = 1024;  // points whose cells are found before they are touched
constexpr std::size_t kAhead = 16;    // cells fetched ahead: a grid is larger than the cache
constexpr std::size_t kNoCell = std::numeric_limits<std::size_t>::max();

// Calls use(cell, z) for each point inside, in order; returns the number outside. `touch(cell)` may prefetch.
template <typename Touch, typename Use>
std::size_t for_each_point(std::span<const Vec3> points, const GridGeometry& g, Touch touch, Use use) {
  std::array<std::size_t, kBlock + kAhead> cell;
  cell.fill(kNoCell);
  const auto columns = static_cast<double>(g.columns), rows = static_cast<double>(g.rows);
  std::size_t outside = 0;
  for (std::size_t begin = 0; begin < points.size(); begin += kBlock) {
    const std::size_t n = std::min(kBlock, points.size() - begin);
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3& p = points[begin + i];
      // Inside, both are at least 0, so that truncation is floor; comparisons with NaN fail.
      const double c = (p.x() - g.west) / g.cell, r = (g.north - p.y()) / g.cell;
      const bool inside = c >= 0.0 && r >= 0.0 && c < columns && r < rows && std::abs(p.z()) < 1e30;
      cell[i] = inside ? static_cast<std::size_t>(r) * g.columns + static_cast<std::size_t>(c) : kNoCell;
    }
    for (std::size_t i = 0; i < std::min(n, kAhead); ++i)
      if (cell[i] != kNoCell) touch(cell[i]);
    for (std::size_t i = 0; i < n; ++i) {
      if (i + kAhead < n && cell[i + kAhead] != kNoCell) touch(cell[i + kAhead]);
      if (cell[i] == kNoCell) {
        ++outside;
      } else {
        use(cell[i], points[begin + i].z());
      }
    }
  }
  return outside;
}

}  // namespace

CellStatistics cell_statistics(std::span<const Vec3> points, const GridGeometry& geometry) {
  struct Cell {
    double sum = 0.0;
    float max = 0.0F;
    std::uint32_t count = 0;
  };
  std::vector<Cell> cells(geometry.cells());
  CellStatistics result;
  result.outside = for_each_point(
      points, geometry, [&](std::size_t k) { __builtin_prefetch(&cells[k], 1); },
      [&](std::size_t k, double z) {
        Cell& cell = cells[k];
        const auto up = static_cast<float>(z);
        cell.max = cell.count == 0 ? up : std::max(cell.max, up);
        cell.sum += z;
        ++cell.count;
      });
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  result.max = {geometry, kNone};
  result.mean = {geometry, kNone};
  result.count = {geometry, 0};
  for (std::size_t k = 0; k < cells.size(); ++k) {
    result.count.values[k] = cells[k].count;
    if (cells[k].count == 0) continue;
    result.max.values[k] = cells[k].max;
    result.mean.values[k] = static_cast<float>(cells[k].sum / cells[k].count);
  }
  return result;
}

geometry::Grid<CellHeights> cell_heights(std::span<const Vec3> points, const GridGeometry& geometry,
                                         std::size_t& outside) {
  geometry::Grid<CellHeights> grid(geometry, CellHeights{});
  auto& cells = grid.values;
  outside = for_each_point(
      points, geometry, [&](std::size_t k) { __builtin_prefetch(&cells[k], 1); },
      [&](std::size_t k, double z) {
        CellHeights& cell = cells[k];
        const auto up = static_cast<float>(z);
        if (cell.points == 0) {
          cell = {up, up, up, up, 1};
          return;
        }
        // With one point both are the same, so the second of two is the other one.
        if (cell.points == 1) {
          cell = {std::min(cell.low, up), std::max(cell.low, up), std::max(cell.low, up), std::min(cell.low, up), 2};
          return;
        }
        cell.second_low = std::min(cell.second_low, std::max(cell.low, up));
        cell.low = std::min(cell.low, up);
        cell.second_high = std::max(cell.second_high, std::min(cell.high, up));
        cell.high = std::max(cell.high, up);
        ++cell.points;
      });
  return grid;
}

}  // namespace cairn::segmentation
