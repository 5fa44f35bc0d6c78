#include "ground/costmap.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "base/parallel.hpp"
#include "ground/distance.hpp"

namespace cairn::ground {
namespace {

using geometry::Grid;

constexpr std::size_t kCellsPerTask = 1 << 16;

// Cells beyond which (9) truncates to 0: 252 exp(-alpha (D - R)) < 1.
int reach_cells(const CostmapOptions& options) {
  const double reach_m = options.radius_m + std::log(252.0) / options.alpha;
  return std::max(1, static_cast<int>(std::ceil(reach_m / options.resolution_m)) + 1);
}

}  // namespace

std::uint8_t cost_at(double distance_m, const CostmapOptions& options) {
  if (distance_m == 0.0) return kLethal;
  if (distance_m <= options.radius_m) return kInscribed;
  return static_cast<std::uint8_t>(static_cast<double>(kSteepestFree) *
                                   std::exp(-options.alpha * (distance_m - options.radius_m)));
}

std::vector<std::size_t> mark_obstacles(const std::vector<survey::Obstacle>& obstacles, Grid<std::uint8_t>& occupancy) {
  std::vector<std::size_t> outside;
  const geometry::GridGeometry& g = occupancy.geometry;
  constexpr auto kOccupied = static_cast<std::uint8_t>(Occupancy::occupied);
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    const survey::Obstacle& o = obstacles[i];
    if (o.kind != survey::ObstacleKind::obstacle) continue;
    const double radius = 0.5 * o.width_m;
    const auto clamp = [](double index, std::size_t count) {
      return static_cast<std::size_t>(std::clamp(index, 0.0, static_cast<double>(count)));
    };
    const double column = (o.position.x() - g.west) / g.cell, row = (g.north - o.position.y()) / g.cell;
    const double span = radius / g.cell + 1.0;
    bool marked = false;
    for (std::size_t r = clamp(std::floor(row - span), g.rows), r1 = clamp(std::ceil(row + span) + 1, g.rows); r < r1;
         ++r)
      for (std::size_t c = clamp(std::floor(column - span), g.columns),
                       c1 = clamp(std::ceil(column + span) + 1, g.columns);
           c < c1; ++c) {
        const geometry::Vec2 d = g.centre(r, c) - geometry::Vec2(o.position.x(), o.position.y());
        if (d.squaredNorm() > radius * radius) continue;
        occupancy.at(r, c) = kOccupied;
        marked = true;
      }
    if (const auto cell = g.cell_at({o.position.x(), o.position.y()})) {
      occupancy.at(cell->first, cell->second) = kOccupied;
      marked = true;
    }
    if (!marked) outside.push_back(i);
  }
  return outside;
}

Grid<std::uint8_t> costmap(const Grid<std::uint8_t>& occupancy, const CostmapOptions& options) {
  CostmapOptions checked = options;
  base::validate(base::bind_options(checked), "costmap");
  if (std::abs(occupancy.geometry.cell - options.resolution_m) > 1e-9)
    throw base::Error(base::ErrorCode::invalid_argument, "the occupancy grid has another resolution")
        .found(base::to_text(occupancy.geometry.cell) + " m")
        .allowed(base::to_text(options.resolution_m) + " m");

  Grid<std::uint8_t> blocked(occupancy.geometry, 0);
  base::parallel_for(occupancy.values.size(), kCellsPerTask, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      blocked.values[i] = occupancy.values[i] == static_cast<std::uint8_t>(Occupancy::occupied) ? 1 : 0;
  });
  const int reach = reach_cells(options);
  const Grid<std::int32_t> squared = squared_distance(blocked, reach);

  // The grid of blocked cells has served; the cost takes its place. One exponential per distinct distance, not per
  // cell.
  std::vector<std::uint8_t> table(static_cast<std::size_t>(reach) * static_cast<std::size_t>(reach) + 2, 0);
  for (std::size_t d2 = 0; d2 + 1 < table.size(); ++d2)
    table[d2] = cost_at(std::sqrt(static_cast<double>(d2)) * options.resolution_m, options);
  base::parallel_for(blocked.values.size(), kCellsPerTask, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      blocked.values[i] = occupancy.values[i] == static_cast<std::uint8_t>(Occupancy::unknown)
                              ? kUnknown
                              : table[static_cast<std::size_t>(squared.values[i])];
  });
  return blocked;
}

}  // namespace cairn::ground
