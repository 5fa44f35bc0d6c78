#include "ground/occupancy.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.hpp"

namespace cairn::ground {
namespace {

using geometry::GridGeometry;
using geometry::Vec2;

// Index of the first cell at or after `position` cells, within 0..count.
std::size_t clamped(double position, std::size_t count) {
  return static_cast<std::size_t>(std::clamp(position, 0.0, static_cast<double>(count)));
}

CellRegion between(std::size_t row, std::size_t end_row, std::size_t column, std::size_t end_column) {
  if (end_row <= row || end_column <= column) return {};
  return {row, column, end_row - row, end_column - column};
}

}  // namespace

CellRegion whole(const GridGeometry& grid) {
  return {0, 0, grid.rows, grid.columns};
}

CellRegion cells_of(const GridGeometry& grid, const Vec2& min, const Vec2& max) {
  if (!(min.x() <= max.x() && min.y() <= max.y())) return {};
  return between(clamped(std::floor((grid.north - max.y()) / grid.cell), grid.rows),
                 clamped(std::floor((grid.north - min.y()) / grid.cell) + 1.0, grid.rows),
                 clamped(std::floor((min.x() - grid.west) / grid.cell), grid.columns),
                 clamped(std::floor((max.x() - grid.west) / grid.cell) + 1.0, grid.columns));
}

CellRegion widened(const CellRegion& region, std::size_t margin, const GridGeometry& grid) {
  if (region.empty()) return {};
  const auto less = [margin](std::size_t i) { return i > margin ? i - margin : 0; };
  return between(less(region.row), std::min(region.end_row() + margin, grid.rows), less(region.column),
                 std::min(region.end_column() + margin, grid.columns));
}

CellRegion joined(const CellRegion& a, const CellRegion& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return between(std::min(a.row, b.row), std::max(a.end_row(), b.end_row()), std::min(a.column, b.column),
                 std::max(a.end_column(), b.end_column()));
}

MarkedObstacles mark_obstacles(std::span<const survey::Obstacle> obstacles, OccupancyGrid& grid) {
  return mark_obstacles(obstacles, grid.geometry, 0, grid);
}

MarkedObstacles mark_obstacles(std::span<const survey::Obstacle> obstacles, const GridGeometry& g,
                               std::size_t first_row, OccupancyGrid& strip) {
  MarkedObstacles result;
  const auto mark = [&](std::size_t r, std::size_t c) {
    if (r >= first_row && r - first_row < strip.geometry.rows) strip.at(r - first_row, c) = Occupancy::occupied;
  };
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    const survey::Obstacle& o = obstacles[i];
    if (o.kind != survey::ObstacleKind::obstacle) continue;
    const Vec2 at(o.position.x(), o.position.y());
    if (!at.allFinite() || !std::isfinite(o.width_m)) {
      result.not_finite.push_back(i);
      continue;
    }
    const double radius = 0.5 * std::max(o.width_m, 0.0);
    CellRegion marked;
    const CellRegion near = cells_of(g, at - Vec2::Constant(radius), at + Vec2::Constant(radius));
    for (std::size_t r = near.row; r < near.end_row(); ++r)
      for (std::size_t c = near.column; c < near.end_column(); ++c) {
        if ((g.centre(r, c) - at).squaredNorm() > radius * radius) continue;
        mark(r, c);
        marked = joined(marked, {r, c, 1, 1});
      }
    if (const auto cell = g.cell_at(at)) {
      mark(cell->first, cell->second);
      marked = joined(marked, {cell->first, cell->second, 1, 1});
    }
    if (marked.empty()) result.outside.push_back(i);
    result.cells = joined(result.cells, marked);
  }
  return result;
}

bool mark_polygon(std::span<const geometry::Ring> rings, Occupancy value, OccupancyGrid& grid) {
  return mark_polygon(rings, value, grid.geometry, 0, grid);
}

bool mark_polygon(std::span<const geometry::Ring> rings, Occupancy value, const GridGeometry& g, std::size_t first_row,
                  OccupancyGrid& strip) {
  bool any = false;
  std::vector<double> crossings;  // east of the rings' edges on the row's middle line
  for (std::size_t r = 0; r < strip.geometry.rows; ++r) {
    const double north = g.centre(first_row + r, 0).y();
    crossings.clear();
    for (const auto& ring : rings)
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const Vec2 &a = ring[i], &b = ring[(i + 1) % ring.size()];
        // Half-open in north, so that a vertex on the line counts once.
        if ((a.y() <= north) == (b.y() <= north)) continue;
        crossings.push_back(a.x() + (north - a.y()) / (b.y() - a.y()) * (b.x() - a.x()));
      }
    std::sort(crossings.begin(), crossings.end());
    for (std::size_t i = 0; i + 1 < crossings.size(); i += 2) {
      const std::size_t begin = clamped(std::ceil((crossings[i] - g.west) / g.cell - 0.5), g.columns);
      const std::size_t end = clamped(std::ceil((crossings[i + 1] - g.west) / g.cell - 0.5), g.columns);
      for (std::size_t c = begin; c < end; ++c) strip.at(r, c) = value;
      any = any || begin < end;
    }
  }
  return any;
}

Occupancy combine(Occupancy prior, Occupancy obstacle, Occupancy scan, const CombineOptions& options) {
  if (scan == Occupancy::occupied) return Occupancy::occupied;
  const bool seen_free = scan == Occupancy::free;
  if (obstacle == Occupancy::occupied && !(seen_free && options.scans_clear_obstacles)) return Occupancy::occupied;
  switch (prior) {
    case Occupancy::occupied: return seen_free && options.scans_clear_prior ? Occupancy::free : Occupancy::occupied;
    case Occupancy::free: return Occupancy::free;
    case Occupancy::unknown: break;
  }
  return seen_free && options.scans_free_unknown ? Occupancy::free : Occupancy::unknown;
}

void combine(const OccupancyGrid& prior, const OccupancyGrid* obstacles, const OccupancyGrid* scans,
             const CombineOptions& options, const CellRegion& region, OccupancyGrid& out) {
  for (const OccupancyGrid* source : {&prior, obstacles, scans})
    if (source != nullptr && !(source->geometry == out.geometry))
      throw base::Error(base::ErrorCode::invalid_argument, "sources of occupancy on different grids");
  if (region.end_row() > out.geometry.rows || region.end_column() > out.geometry.columns)
    throw base::Error(base::ErrorCode::invalid_argument, "a region that reaches beyond the grid");
  // The rule once for each of the 27 cases, not for each cell.
  std::array<Occupancy, 27> rule{};
  for (std::size_t i = 0; i < rule.size(); ++i)
    rule[i] = combine(static_cast<Occupancy>(i / 9), static_cast<Occupancy>(i / 3 % 3), static_cast<Occupancy>(i % 3),
                      options);
  constexpr std::size_t kSilent = 2;
  for (std::size_t r = region.row; r < region.end_row(); ++r) {
    const std::size_t row = r * out.geometry.columns + region.column;
    for (std::size_t i = row; i < row + region.columns; ++i) {
      const std::size_t obstacle = obstacles != nullptr ? static_cast<std::size_t>(obstacles->values[i]) : kSilent;
      const std::size_t scan = scans != nullptr ? static_cast<std::size_t>(scans->values[i]) : kSilent;
      out.values[i] = rule[9 * static_cast<std::size_t>(prior.values[i]) + 3 * obstacle + scan];
    }
  }
}

}  // namespace cairn::ground
