// Oracle for routes: Dijkstra's algorithm, cell by cell, with nothing clever.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <queue>
#include <vector>

#include "geometry/grid.hpp"
#include "ground/costmap.hpp"
#include "ground/route.hpp"

namespace cairn::testing {

// Least weighted length [cells] between two cells of a costmap, infinite where there is no path.
inline double dijkstra(const geometry::Grid<std::uint8_t>& cost, const ground::Cell& start, const ground::Cell& goal,
                       double weight) {
  const auto rows = static_cast<int>(cost.geometry.rows), columns = static_cast<int>(cost.geometry.columns);
  const auto at = [&](int r, int c) { return cost.values[static_cast<std::size_t>(r * columns + c)]; };
  const auto free = [&](int r, int c) {
    return r >= 0 && c >= 0 && r < rows && c < columns && at(r, c) < ground::kInscribed;
  };
  const auto factor = [&](int r, int c) { return 1.0 + weight * at(r, c) / 252.0; };
  std::vector<double> best(cost.values.size(), std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  const auto index = [&](const ground::Cell& cell) {
    return static_cast<int>(cell.first * cost.geometry.columns + cell.second);
  };
  best[static_cast<std::size_t>(index(start))] = 0.0;
  open.push({0.0, index(start)});
  while (!open.empty()) {
    const auto [distance, here] = open.top();
    open.pop();
    if (here == index(goal)) break;
    if (distance > best[static_cast<std::size_t>(here)]) continue;
    const int r = here / columns, c = here % columns;
    for (int dr = -1; dr <= 1; ++dr)
      for (int dc = -1; dc <= 1; ++dc) {
        if ((dr == 0 && dc == 0) || !free(r + dr, c + dc) || !free(r + dr, c) || !free(r, c + dc)) continue;
        const double d = distance + std::sqrt(static_cast<double>(dr * dr + dc * dc)) * 0.5 *
                                        (factor(r, c) + factor(r + dr, c + dc));
        const int next = (r + dr) * columns + c + dc;
        if (d >= best[static_cast<std::size_t>(next)]) continue;
        best[static_cast<std::size_t>(next)] = d;
        open.push({d, next});
      }
  }
  return best[static_cast<std::size_t>(index(goal))];
}

}  // namespace cairn::testing
