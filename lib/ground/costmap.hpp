// Cost of driving: paper B, equation (9).
#pragma once

#include <cstdint>
#include <vector>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "geometry/grid.hpp"
#include "survey/obstacle.hpp"

namespace cairn::ground {

// Values of a costmap, as in ROS costmap_2d.
inline constexpr std::uint8_t kUnknown = 255;
inline constexpr std::uint8_t kLethal = 254;     // an obstacle stands in the cell
inline constexpr std::uint8_t kInscribed = 253;  // the vehicle's centre in the cell means contact
inline constexpr std::uint8_t kSteepestFree = 252;

// Values of an occupancy grid.
enum class Occupancy : std::uint8_t { free = 0, occupied = 1, unknown = 2 };

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

// Marks the cells whose centre lies within half the width of an obstacle, and always the cell its
// position is in. `ignored` obstacles and vehicles leave no mark. Obstacles outside the grid are
// returned by index. Cost: cells covered.
[[nodiscard]] std::vector<std::size_t> mark_obstacles(const std::vector<survey::Obstacle>& obstacles,
                                                      geometry::Grid<std::uint8_t>& occupancy);

// Equation (9) over an occupancy grid (values of Occupancy). Unknown cells stay unknown. Distance is
// Euclidean between cell centres, exact. Cost linear in cells.
// The grid's cell must equal options.resolution_m within 1e-9.
[[nodiscard]] geometry::Grid<std::uint8_t> costmap(const geometry::Grid<std::uint8_t>& occupancy,
                                                   const CostmapOptions& options);

}  // namespace cairn::ground
