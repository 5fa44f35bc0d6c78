#include "ground/route.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "base/error.hpp"
#include "ground/costmap.hpp"
#include "ground/jump_points.hpp"
#include "ground/weighted_path.hpp"

namespace cairn::ground {
namespace {

using geometry::Grid;

constexpr double kDiagonal = std::numbers::sqrt2;
// Row and column numbers with the border fit 28 bits.
constexpr std::size_t kMostLines = 200'000'000;

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

double length_of(std::int64_t straight, std::int64_t diagonal) {
  return static_cast<double>(straight) + kDiagonal * static_cast<double>(diagonal);
}

// The factor of all free cells where they have but one.
std::optional<double> only_factor(const Grid<std::uint8_t>& cost, const StepFactors& factors) {
  // Four tables: equal neighbours would otherwise wait for one another's store.
  std::array<std::array<std::uint8_t, 256>, 4> present{};
  for (std::size_t i = 0; i < cost.values.size(); ++i) present[i & 3][cost.values[i]] = 1;
  std::optional<double> only;
  for (std::size_t value = 0; value < factors.size(); ++value) {
    const bool here = (present[0][value] | present[1][value] | present[2][value] | present[3][value]) != 0;
    if (!here || !(factors[value] > 0.0)) continue;
    if (only && *only != factors[value]) return std::nullopt;
    only = factors[value];
  }
  return only;
}

// All cells between turning points that are joined by straight or diagonal steps.
std::vector<std::pair<std::int64_t, std::int64_t>> every_cell(
    const std::vector<std::pair<std::int64_t, std::int64_t>>& corners) {
  std::vector<std::pair<std::int64_t, std::int64_t>> cells;
  const auto sign = [](std::int64_t v) { return static_cast<std::int64_t>(v > 0) - static_cast<std::int64_t>(v < 0); };
  for (const auto& corner : corners) {
    if (cells.empty()) cells.push_back(corner);
    while (cells.back() != corner)
      cells.emplace_back(cells.back().first + sign(corner.first - cells.back().first),
                         cells.back().second + sign(corner.second - cells.back().second));
  }
  return cells;
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
  const auto& g = cost.geometry;
  if (g.rows > kMostLines || g.columns > kMostLines)
    throw base::Error(base::ErrorCode::invalid_argument, "the costmap is too large for a route")
        .found(std::to_string(g.columns) + " x " + std::to_string(g.rows) + " cells")
        .allowed("at most " + std::to_string(kMostLines) + " a side");
  const auto is_free = [&](const Cell& cell) {
    return cell.first < g.rows && cell.second < g.columns && drivable(cost.at(cell.first, cell.second), options);
  };
  Route route;
  if (!is_free(start)) route.reason = "start_blocked";
  else if (!is_free(goal)) route.reason = "goal_blocked";
  if (!route.reason.empty()) return route;

  StepFactors factors{};
  for (std::size_t value = 0; value < factors.size(); ++value) {
    const auto byte = static_cast<std::uint8_t>(value);
    factors[value] = drivable(byte, options) ? step_factor(byte, options) : 0.0;
  }
  const auto signed_cell = [](const Cell& cell) {
    return std::pair(static_cast<std::int64_t>(cell.first), static_cast<std::int64_t>(cell.second));
  };
  std::vector<std::pair<std::int64_t, std::int64_t>> cells;
  if (const auto factor = only_factor(cost, factors)) {
    std::vector<std::uint8_t> blocked(factors.size());
    for (std::size_t value = 0; value < factors.size(); ++value) blocked[value] = factors[value] > 0.0 ? 0 : 1;
    const JumpPath path = jump_path(BlockedBits(cost, blocked), signed_cell(start), signed_cell(goal), ctx);
    cells = every_cell(path.corners);
    route.expansions = path.expansions;
    route.weighted_length_m = *factor * length_of(path.straight, path.diagonal) * g.cell;
  } else {
    WeightedPath path = weighted_path(cost, factors, signed_cell(start), signed_cell(goal), ctx);
    cells = std::move(path.cells);
    route.expansions = path.expansions;
    route.weighted_length_m = path.weighted * g.cell;
  }
  route.found = !cells.empty();
  if (!route.found) {
    route.reason = "no_path";
    return route;
  }
  std::int64_t straight = 0, diagonal = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    route.path.push_back(g.centre(static_cast<std::size_t>(cells[i].first), static_cast<std::size_t>(cells[i].second)));
    if (i == 0) continue;
    if (cells[i].first != cells[i - 1].first && cells[i].second != cells[i - 1].second) ++diagonal;
    else ++straight;
  }
  route.length_m = length_of(straight, diagonal) * g.cell;
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
