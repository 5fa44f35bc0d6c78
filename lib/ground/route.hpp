// Shortest path over a costmap: A* (Hart, Nilsson & Raphael 1968).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "geometry/grid.hpp"
#include "geometry/vec.hpp"

namespace cairn::ground {

struct RouteOptions {
  // Length of a step is multiplied by 1 + weight * cost / 252; 0 = plain shortest.
  double cost_weight = 5.0;
  bool allow_unknown = false;  // drive through unknown cells, at the cost of a free one

  void visit(base::OptionVisitor& v) {
    v.real("cost-weight", cost_weight, 0.0, 1000.0, "how much costly cells are avoided; 0 = plain shortest");
    v.flag("allow-unknown", allow_unknown, "drive through unknown cells");
  }
};

// Whether a cell of this cost can be driven on: below 253, or unknown where that is allowed.
[[nodiscard]] bool drivable(std::uint8_t cost, const RouteOptions& options);
// What a metre in a cell of this cost counts: 1 + weight * cost / 252; blocked cells count as cost 252.
[[nodiscard]] double step_factor(std::uint8_t cost, const RouteOptions& options);

using Cell = std::pair<std::size_t, std::size_t>;  // row, column

struct Route {
  bool found = false;
  std::string reason;                // where not found: start_blocked, goal_blocked, no_path
  std::vector<geometry::Vec2> path;  // centres of the cells, local ENU east and north, m
  double length_m = 0.0;
  double weighted_length_m = 0.0;  // what A* minimised
  std::uint64_t expansions = 0;
};

// 8-connected, corners are not cut: a diagonal step needs both cells beside it free. Cells with cost
// >= 253 are blocked. Optimal for the weighted length and deterministic. Where all drivable cells count the same
// (cost_weight 0, or a map of free and blocked cells only) by jump points (ground/jump_points.hpp; expansions are then
// jump points), else by A* cell by cell (ground/weighted_path.hpp).
[[nodiscard]] Route find_route(const geometry::Grid<std::uint8_t>& cost, const Cell& start, const Cell& goal,
                               const RouteOptions& options, base::RunContext& ctx);

// Two cells far apart in the largest connected free region: ends for a demonstration where the user
// gave none. Breadth-first sweeps from the region's first cell and from the farthest one found; the
// second end is the farthest from the first. Empty where no cell is free.
[[nodiscard]] std::optional<std::pair<Cell, Cell>> far_apart(const geometry::Grid<std::uint8_t>& cost,
                                                             const RouteOptions& options);

// Drops the points of a path that lie on the straight line between their neighbours; exact.
[[nodiscard]] std::vector<geometry::Vec2> without_collinear(const std::vector<geometry::Vec2>& path);

}  // namespace cairn::ground
