#include "ground/route.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>

#include "ground/costmap.hpp"

namespace cairn::ground {
namespace {

using geometry::Grid;

constexpr double kDiagonal = std::numbers::sqrt2;
constexpr std::uint8_t kNoParent = 255;
constexpr std::uint64_t kStopInterval = 1 << 16;

struct Move {
  int row, column;
  double length;  // cells
};
constexpr std::array<Move, 8> kMoves{{{-1, 0, 1.0},
                                      {0, -1, 1.0},
                                      {0, 1, 1.0},
                                      {1, 0, 1.0},
                                      {-1, -1, kDiagonal},
                                      {-1, 1, kDiagonal},
                                      {1, -1, kDiagonal},
                                      {1, 1, kDiagonal}}};

class Field {
 public:
  Field(const Grid<std::uint8_t>& cost, const RouteOptions& options)
      : cost_(cost),
        columns_(static_cast<std::int64_t>(cost.geometry.columns)),
        rows_(static_cast<std::int64_t>(cost.geometry.rows)) {
    for (std::size_t value = 0; value < factor_.size(); ++value)
      factor_[value] =
          value >= kInscribed ? 0.0 : 1.0 + options.cost_weight * static_cast<double>(value) / kSteepestFree;
    if (options.allow_unknown) factor_[kUnknown] = 1.0;
  }

  [[nodiscard]] bool free(std::int64_t row, std::int64_t column) const {
    return row >= 0 && column >= 0 && row < rows_ && column < columns_ && factor(row * columns_ + column) > 0.0;
  }
  [[nodiscard]] double factor(std::int64_t index) const {
    return factor_[cost_.values[static_cast<std::size_t>(index)]];
  }
  // Whether a move from a free cell stays on free cells without cutting a corner.
  [[nodiscard]] bool open(std::int64_t row, std::int64_t column, const Move& move) const {
    if (!free(row + move.row, column + move.column)) return false;
    return move.row == 0 || move.column == 0 || (free(row + move.row, column) && free(row, column + move.column));
  }
  [[nodiscard]] std::int64_t columns() const { return columns_; }
  [[nodiscard]] std::int64_t rows() const { return rows_; }

 private:
  const Grid<std::uint8_t>& cost_;
  std::int64_t columns_, rows_;
  std::array<double, 256> factor_{};
};

double octile(std::int64_t rows, std::int64_t columns) {
  const auto a = static_cast<double>(std::abs(rows)), b = static_cast<double>(std::abs(columns));
  return std::max(a, b) + (kDiagonal - 1.0) * std::min(a, b);
}

struct Entry {
  double estimate, travelled;
  std::int64_t index;
  // The queue's top is the least estimate, then the farthest travelled, then the least index.
  friend bool operator<(const Entry& a, const Entry& b) {
    if (a.estimate != b.estimate) return a.estimate > b.estimate;
    if (a.travelled != b.travelled) return a.travelled < b.travelled;
    return a.index > b.index;
  }
};

// Steps of a breadth-first sweep over one region; the last cell reached is among the farthest.
struct Sweep {
  std::int64_t last = -1;
  std::size_t cells = 0;
};

Sweep sweep(const Field& field, std::int64_t from, std::vector<std::uint32_t>& mark, std::uint32_t label) {
  std::vector<std::int64_t> queue{from};
  mark[static_cast<std::size_t>(from)] = label;
  for (std::size_t i = 0; i < queue.size(); ++i) {
    const std::int64_t row = queue[i] / field.columns(), column = queue[i] % field.columns();
    for (const Move& move : kMoves) {
      if (!field.open(row, column, move)) continue;
      const std::int64_t next = queue[i] + move.row * field.columns() + move.column;
      if (mark[static_cast<std::size_t>(next)] == label) continue;
      mark[static_cast<std::size_t>(next)] = label;
      queue.push_back(next);
    }
  }
  return {queue.back(), queue.size()};
}

}  // namespace

bool drivable(std::uint8_t cost, const RouteOptions& options) {
  return cost < kInscribed || (cost == kUnknown && options.allow_unknown);
}

double step_factor(std::uint8_t cost, const RouteOptions& options) {
  if (cost == kUnknown && options.allow_unknown) return 1.0;
  return 1.0 + options.cost_weight * std::min<double>(cost, kSteepestFree) / kSteepestFree;
}

Route find_route(const Grid<std::uint8_t>& cost, const Cell& start, const Cell& goal, const RouteOptions& options,
                 base::RunContext& ctx) {
  RouteOptions checked = options;
  base::validate(base::bind_options(checked), "route");
  const Field field(cost, options);
  const auto index_of = [&](const Cell& cell) {
    return static_cast<std::int64_t>(cell.first) * field.columns() + static_cast<std::int64_t>(cell.second);
  };
  const auto is_free = [&](const Cell& cell) {
    return field.free(static_cast<std::int64_t>(cell.first), static_cast<std::int64_t>(cell.second));
  };
  Route route;
  if (!is_free(start)) route.reason = "start_blocked";
  else if (!is_free(goal)) route.reason = "goal_blocked";
  if (!route.reason.empty()) return route;

  const std::int64_t source = index_of(start), target = index_of(goal);
  const std::int64_t goal_row = target / field.columns(), goal_column = target % field.columns();
  std::vector<double> best(cost.values.size(), std::numeric_limits<double>::infinity());
  std::vector<std::uint8_t> parent(cost.values.size(), kNoParent);
  std::priority_queue<Entry> open;
  best[static_cast<std::size_t>(source)] = 0.0;
  open.push({octile(source / field.columns() - goal_row, source % field.columns() - goal_column), 0.0, source});
  while (!open.empty()) {
    const Entry entry = open.top();
    open.pop();
    if (entry.travelled > best[static_cast<std::size_t>(entry.index)]) continue;
    if (++route.expansions % kStopInterval == 0) ctx.check_stop();
    if (entry.index == target) {
      route.found = true;
      break;
    }
    const std::int64_t row = entry.index / field.columns(), column = entry.index % field.columns();
    const double here = field.factor(entry.index);
    for (std::size_t m = 0; m < kMoves.size(); ++m) {
      const Move& move = kMoves[m];
      if (!field.open(row, column, move)) continue;
      const std::int64_t next = entry.index + move.row * field.columns() + move.column;
      const double travelled = entry.travelled + move.length * 0.5 * (here + field.factor(next));
      if (travelled >= best[static_cast<std::size_t>(next)]) continue;
      best[static_cast<std::size_t>(next)] = travelled;
      parent[static_cast<std::size_t>(next)] = static_cast<std::uint8_t>(m);
      open.push({travelled + octile(row + move.row - goal_row, column + move.column - goal_column), travelled, next});
    }
  }
  if (!route.found) {
    route.reason = "no_path";
    return route;
  }
  route.weighted_length_m = best[static_cast<std::size_t>(target)] * cost.geometry.cell;
  double cells = 0.0;
  for (std::int64_t at = target;;) {
    route.path.push_back(cost.geometry.centre(static_cast<std::size_t>(at / field.columns()),
                                              static_cast<std::size_t>(at % field.columns())));
    if (at == source) break;
    const Move& move = kMoves[parent[static_cast<std::size_t>(at)]];
    cells += move.length;
    at -= move.row * field.columns() + move.column;
  }
  std::reverse(route.path.begin(), route.path.end());
  route.length_m = cells * cost.geometry.cell;
  return route;
}

std::optional<std::pair<Cell, Cell>> far_apart(const Grid<std::uint8_t>& cost, const RouteOptions& options) {
  const Field field(cost, options);
  std::vector<std::uint32_t> mark(cost.values.size(), 0);
  Sweep largest;
  std::uint32_t label = 0;
  for (std::int64_t i = 0; i < field.rows() * field.columns(); ++i) {
    if (mark[static_cast<std::size_t>(i)] != 0 || !(field.factor(i) > 0.0)) continue;
    const Sweep region = sweep(field, i, mark, ++label);
    if (region.cells > largest.cells) largest = region;
  }
  if (largest.last < 0) return std::nullopt;
  const std::int64_t first = sweep(field, largest.last, mark, ++label).last;
  const std::int64_t second = sweep(field, first, mark, ++label).last;
  const auto cell = [&](std::int64_t index) {
    return Cell(static_cast<std::size_t>(index / field.columns()), static_cast<std::size_t>(index % field.columns()));
  };
  return std::pair(cell(first), cell(second));
}

std::vector<geometry::Vec2> without_collinear(const std::vector<geometry::Vec2>& path) {
  std::vector<geometry::Vec2> kept;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (i > 0 && i + 1 < path.size()) {
      const geometry::Vec2 before = path[i] - path[i - 1], after = path[i + 1] - path[i];
      // Steps of one grid: equal directions give equal vectors but for the rounding of the centres.
      constexpr double kSameStep_m = 1e-6;
      if ((before - after).cwiseAbs().maxCoeff() < kSameStep_m) continue;
    }
    kept.push_back(path[i]);
  }
  return kept;
}

}  // namespace cairn::ground
