// Cost of driving: paper B, equation (9).
#pragma once

#include <cstdint>
#include <vector>

#include "base/options.hpp"
#include "geometry/grid.hpp"
#include "ground/occupancy.hpp"

namespace cairn::ground {

// Values of a costmap, as in ROS costmap_2d.
inline constexpr std::uint8_t kUnknown = 255;
inline constexpr std::uint8_t kLethal = 254;     // an obstacle stands in the cell
inline constexpr std::uint8_t kInscribed = 253;  // the vehicle's centre in the cell means contact
inline constexpr std::uint8_t kSteepestFree = 252;

struct CostmapOptions {
  double radius_m = 0.35;      // R of (9): radius of the vehicle; the paper gives none
  double alpha = 3.0;          // of (9), 1/m
  double resolution_m = 0.05;  // edge of a cell; paper B, B13

  void visit(base::OptionVisitor& v) {
    v.real("radius-m", radius_m, 0.0, 100.0, "radius of the vehicle, R of equation (9)");
    v.real("alpha", alpha, 0.01, 100.0, "fall of the cost with distance, 1/m");
    v.real("resolution-m", resolution_m, 0.005, 10.0, "edge of a cell");
  }
};

// Cost at distance D [m] from the nearest obstacle cell, (9) truncated to a byte as ROS does:
//   254 if D = 0;  253 if D <= R;  252 exp(-alpha (D - R)) beyond.
[[nodiscard]] std::uint8_t cost_at(double distance_m, const CostmapOptions& options);

// Whole cells beyond which an obstacle adds nothing to the cost of a cell; >= 1.
[[nodiscard]] int reach_cells(const CostmapOptions& options);

// Equation (9) over an occupancy grid. D = sqrt(dr^2 + dc^2) * resolution between cell centres, exact: equal to looking
// at every pair of cells, to the last bit. Unknown cells stay unknown and are no obstacles. The distance is not
// followed beyond reach_cells. Cost linear in cells, memory 1 byte a cell for the result and some rows for each thread.
// The grid's cell must equal options.resolution_m within 1e-9.
[[nodiscard]] geometry::Grid<std::uint8_t> costmap(const OccupancyGrid& occupancy, const CostmapOptions& options);

// Brings `cost` up to date after cells inside `changed` have changed: only those and the cells within reach of them are
// computed again, to the same bytes as costmap() of the whole. Returns the cells written.
// Cost: 0.4 s of 10 000 x 10 000 cells, pro rata; a window of 10 m at 0.05 m takes about 1 ms.
CellRegion update_costmap(const OccupancyGrid& occupancy, const CellRegion& changed, const CostmapOptions& options,
                          geometry::Grid<std::uint8_t>& cost);

}  // namespace cairn::ground
