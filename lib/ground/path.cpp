#include "ground/path.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "ground/costmap.hpp"

namespace cairn::ground {
namespace {

using geometry::Grid;
using geometry::Vec2;

// Borders of cells nearer than this along a line [cells] are crossed at a corner.
constexpr double kCorner = 1e-9;
// A line that does not serve may be followed by longer ones that do: so many points are tried on.
constexpr std::size_t kPatience = 32;

// Calls visit(row, column, length in cells) for each cell that a line crosses, in order; at corners for the two cells
// beside with length 0. Rows and columns may lie outside the grid. Stops where visit returns false.
template <typename Visit>
bool cross_cells(const geometry::GridGeometry& g, const Vec2& from, const Vec2& to, const Visit& visit) {
  const double x0 = (from.x() - g.west) / g.cell, y0 = (g.north - from.y()) / g.cell;
  const double dx = (to.x() - from.x()) / g.cell, dy = (from.y() - to.y()) / g.cell;
  const double length = std::hypot(dx, dy);
  auto column = static_cast<std::int64_t>(std::floor(x0)), row = static_cast<std::int64_t>(std::floor(y0));
  const std::int64_t step_x = dx > 0.0 ? 1 : -1, step_y = dy > 0.0 ? 1 : -1;
  constexpr double kNever = std::numeric_limits<double>::infinity();
  // Way in cells to the next border of either kind.
  const double per_x = dx == 0.0 ? kNever : length / std::abs(dx), per_y = dy == 0.0 ? kNever : length / std::abs(dy);
  const auto first = [](double at, double d) { return d > 0.0 ? std::floor(at) + 1.0 - at : at - std::floor(at); };
  double next_x = dx == 0.0 ? kNever : per_x * first(x0, dx), next_y = dy == 0.0 ? kNever : per_y * first(y0, dy);
  double at = 0.0;
  for (;;) {
    const double next = std::min({next_x, next_y, length});
    if (!visit(row, column, next - at)) return false;
    if (next >= length - kCorner) return true;
    at = next;
    const bool in_x = next_x <= next + kCorner, in_y = next_y <= next + kCorner;
    if (in_x && in_y && (!visit(row, column + step_x, 0.0) || !visit(row + step_y, column, 0.0))) return false;
    if (in_x) {
      column += step_x;
      next_x += per_x;
    }
    if (in_y) {
      row += step_y;
      next_y += per_y;
    }
  }
}

// Value of a cell by signed row and column; unknown outside.
std::uint8_t value_at(const Grid<std::uint8_t>& cost, std::int64_t row, std::int64_t column) {
  const auto& g = cost.geometry;
  if (row < 0 || column < 0 || row >= static_cast<std::int64_t>(g.rows) ||
      column >= static_cast<std::int64_t>(g.columns))
    return kUnknown;
  return cost.at(static_cast<std::size_t>(row), static_cast<std::size_t>(column));
}

// Nearness of a cell to obstacles: less is nearer.
std::int32_t remoteness(const Grid<std::uint8_t>& cost, const Grid<std::int32_t>* squared, std::int64_t row,
                        std::int64_t column) {
  if (squared != nullptr) return squared->at(static_cast<std::size_t>(row), static_cast<std::size_t>(column));
  return -static_cast<std::int32_t>(value_at(cost, row, column));
}

struct Piece {
  bool drivable = true;
  double weighted = 0.0;  // cells
  std::int32_t remoteness = std::numeric_limits<std::int32_t>::max();
};

Piece measure(const Grid<std::uint8_t>& cost, const Vec2& from, const Vec2& to, const RouteOptions& options,
              const Grid<std::int32_t>* squared) {
  Piece piece;
  piece.drivable = cross_cells(cost.geometry, from, to, [&](std::int64_t row, std::int64_t column, double length) {
    const std::uint8_t value = value_at(cost, row, column);
    if (!drivable(value, options)) return false;
    piece.weighted += length * step_factor(value, options);
    // Cells that are touched at a corner only must be free, but the line is not in them.
    if (length > 0.0) piece.remoteness = std::min(piece.remoteness, remoteness(cost, squared, row, column));
    return true;
  });
  return piece;
}

}  // namespace

double length_m(const std::vector<Vec2>& path) {
  double sum = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) sum += (path[i] - path[i - 1]).norm();
  return sum;
}

double weighted_length_m(const Grid<std::uint8_t>& cost, const std::vector<Vec2>& path, const RouteOptions& options) {
  double sum = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i)
    cross_cells(cost.geometry, path[i - 1], path[i], [&](std::int64_t row, std::int64_t column, double length) {
      sum += length * step_factor(value_at(cost, row, column), options);
      return true;
    });
  return sum * cost.geometry.cell;
}

double clearance_m(const Grid<std::uint8_t>& cost, const std::vector<Vec2>& path, double farthest_m) {
  const auto& g = cost.geometry;
  const auto rows = static_cast<std::int64_t>(g.rows), columns = static_cast<std::int64_t>(g.columns);
  const double reach = std::min(farthest_m / g.cell, static_cast<double>(g.rows + g.columns));
  auto least = static_cast<std::int64_t>(reach * reach);  // squared, in cells
  bool capped = true;
  // Obstacle cells of a row between two columns that are nearer than `least`.
  const auto look = [&](std::int64_t row, std::int64_t column) {
    for (std::int64_t away = 0; away * away < least; ++away)
      for (const std::int64_t r : {row - away, row + away}) {
        if (r < 0 || r >= rows || (away == 0 && r != row)) continue;
        const auto half = static_cast<std::int64_t>(std::sqrt(static_cast<double>(least - away * away)));
        const std::int64_t lo = std::max<std::int64_t>(0, column - half), hi = std::min(columns - 1, column + half);
        const std::uint8_t* line = &cost.values[static_cast<std::size_t>(r) * g.columns];
        for (std::int64_t c = lo; c <= hi;) {
          const void* hit = std::memchr(line + c, kLethal, static_cast<std::size_t>(hi - c + 1));
          if (hit == nullptr) break;
          c = static_cast<const std::uint8_t*>(hit) - line;
          const std::int64_t squared = away * away + (c - column) * (c - column);
          if (squared < least) {
            least = squared;
            capped = false;
          }
          ++c;
        }
      }
  };
  const auto visit = [&](std::int64_t row, std::int64_t column, double length) {
    // Beside a corner that the path passes through it is in neither cell.
    if (length > 0.0 && row >= 0 && row < rows && column >= 0 && column < columns) look(row, column);
    return true;
  };
  if (path.size() == 1) {
    if (const auto cell = g.cell_at(path[0]))
      look(static_cast<std::int64_t>(cell->first), static_cast<std::int64_t>(cell->second));
  }
  for (std::size_t i = 1; i < path.size(); ++i) cross_cells(g, path[i - 1], path[i], visit);
  return capped ? farthest_m : std::sqrt(static_cast<double>(least)) * g.cell;
}

std::vector<Vec2> smoothed(const Grid<std::uint8_t>& cost, const std::vector<Vec2>& path, const RouteOptions& options,
                           const Grid<std::int32_t>* squared) {
  if (path.size() < 3) return path;
  std::vector<Vec2> kept{path.front()};
  for (std::size_t from = 0; from + 1 < path.size();) {
    // The piece from `from` to `to`, and the farthest point that one line does for.
    Piece piece;
    std::size_t reached = from + 1;
    for (std::size_t to = from + 1; to < path.size() && to <= reached + kPatience; ++to) {
      const Piece step = measure(cost, path[to - 1], path[to], options, squared);
      piece.weighted += step.weighted;
      piece.remoteness = std::min(piece.remoteness, step.remoteness);
      if (to == from + 1) continue;
      const Piece line = measure(cost, path[from], path[to], options, squared);
      constexpr double kEqual = 1e-9;  // straight pieces replace themselves
      if (line.drivable && line.weighted <= piece.weighted * (1.0 + kEqual) && line.remoteness >= piece.remoteness)
        reached = to;
    }
    kept.push_back(path[reached]);
    from = reached;
  }
  return kept;
}

std::vector<Vec2> with_points(const std::vector<Vec2>& path, double step) {
  std::vector<Vec2> dense;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (i > 0) {
      const Vec2 way = path[i] - path[i - 1];
      const auto parts = static_cast<int>(std::ceil(way.norm() / step - 1e-9));
      for (int k = 1; k < parts; ++k) dense.emplace_back(path[i - 1] + way * (static_cast<double>(k) / parts));
    }
    dense.push_back(path[i]);
  }
  return dense;
}

}  // namespace cairn::ground
