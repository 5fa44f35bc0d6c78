// Least-cost paths on a map whose cells cost differently: A* with a bucket queue.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/run_context.hpp"
#include "geometry/grid.hpp"

namespace cairn::ground {

struct WeightedPath {
  // Every cell from the start to the goal, row and column; empty = there is no path.
  std::vector<std::pair<std::int64_t, std::int64_t>> cells;
  double weighted = 0.0;  // in cells
  std::uint64_t expansions = 0;
};

// What a step of one cell counts in a cell, by the cell's cost; 0 = blocked, else >= 1.
using StepFactors = std::array<double, 256>;

// The 8-connected path that cuts no corners of the least sum of step length x mean factor of both cells. A* (Hart,
// Nilsson & Raphael 1968) with the octile distance times the map's least factor as the estimate; the open list is a row
// of buckets (Dial 1969), within which cells are taken last in, first out and again where a shorter way to them is
// found, until no bucket could still better the goal. Optimal to rounding (1e-12 of the sum). Start and goal are free
// cells. Memory 9 bytes a cell, of which only the part around the cells visited is touched, plus the open list.
[[nodiscard]] WeightedPath weighted_path(const geometry::Grid<std::uint8_t>& cost, const StepFactors& factors,
                                         std::pair<std::int64_t, std::int64_t> start,
                                         std::pair<std::int64_t, std::int64_t> goal, base::RunContext& ctx);

}  // namespace cairn::ground
