#include "ground/costmap.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "ground/inflation.hpp"

namespace cairn::ground {
namespace {

using geometry::Grid;

void check_cell(const OccupancyGrid& occupancy, const CostmapOptions& options) {
  if (std::abs(occupancy.geometry.cell - options.resolution_m) > 1e-9)
    throw base::Error(base::ErrorCode::invalid_argument, "the occupancy grid has another resolution")
        .found(base::to_text(occupancy.geometry.cell) + " m")
        .allowed(base::to_text(options.resolution_m) + " m");
}

}  // namespace

std::uint8_t cost_at(double distance_m, const CostmapOptions& options) {
  if (distance_m == 0.0) return kLethal;
  if (distance_m <= options.radius_m) return kInscribed;
  return static_cast<std::uint8_t>(static_cast<double>(kSteepestFree) *
                                   std::exp(-options.alpha * (distance_m - options.radius_m)));
}

int reach_cells(const CostmapOptions& options) {
  // Beyond this (9) truncates to 0: 252 exp(-alpha (D - R)) < 1.
  const double reach_m = options.radius_m + std::log(static_cast<double>(kSteepestFree)) / options.alpha;
  return std::max(1, static_cast<int>(std::ceil(reach_m / options.resolution_m)) + 1);
}

Grid<std::uint8_t> costmap(const OccupancyGrid& occupancy, const CostmapOptions& options) {
  const Inflation inflation(options);
  check_cell(occupancy, options);
  Grid<std::uint8_t> cost(occupancy.geometry, 0);
  inflation.run(occupancy, whole(occupancy.geometry), cost.values.data(), cost.geometry.columns);
  return cost;
}

CellRegion update_costmap(const OccupancyGrid& occupancy, const CellRegion& changed, const CostmapOptions& options,
                          Grid<std::uint8_t>& cost) {
  const Inflation inflation(options);
  check_cell(occupancy, options);
  if (!(cost.geometry == occupancy.geometry))
    throw base::Error(base::ErrorCode::invalid_argument, "cost and occupancy on different grids");
  if (changed.end_row() > cost.geometry.rows || changed.end_column() > cost.geometry.columns)
    throw base::Error(base::ErrorCode::invalid_argument, "a region that reaches beyond the grid");
  const CellRegion region = widened(changed, static_cast<std::size_t>(inflation.reach()), cost.geometry);
  if (!region.empty()) inflation.run(occupancy, region, &cost.at(region.row, region.column), cost.geometry.columns);
  return region;
}

}  // namespace cairn::ground
