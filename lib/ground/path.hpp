// Paths over a costmap: what they cost, how near they pass to obstacles, and straightening them.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/grid.hpp"
#include "geometry/vec.hpp"
#include "ground/route.hpp"

namespace cairn::ground {

// Points of a path: local ENU east and north, m; straight between them.

[[nodiscard]] double length_m(const std::vector<geometry::Vec2>& path);

// Length times step_factor, cell by cell as the line crosses them. Outside the grid counts as blocked.
[[nodiscard]] double weighted_length_m(const geometry::Grid<std::uint8_t>& cost,
                                       const std::vector<geometry::Vec2>& path, const RouteOptions& options);

// Least distance between the centre of a cell that the path crosses and the centre of an obstacle cell (254), at most
// `farthest_m`. Only cells nearer than the least found so far are looked at: cost about cells of the path times the
// square of the result in cells.
[[nodiscard]] double clearance_m(const geometry::Grid<std::uint8_t>& cost, const std::vector<geometry::Vec2>& path,
                                 double farthest_m);

// Straightens a path of find_route: from each kept point on, as far as one straight line does for what it replaces. A
// line serves where every cell it touches (at a corner all four) is drivable, where it costs no more (weighted), and
// where it keeps the clearance: with `squared` (squared_distance of the obstacle cells, cells^2) no cell of it is
// nearer to an obstacle than the nearest of the piece replaced; without, no cell of it costs more than the costliest of
// that piece. Returns the kept points, the first and the last included. Cost: points times the length of the lines
// tried, in cells.
[[nodiscard]] std::vector<geometry::Vec2> smoothed(const geometry::Grid<std::uint8_t>& cost,
                                                   const std::vector<geometry::Vec2>& path, const RouteOptions& options,
                                                   const geometry::Grid<std::int32_t>* squared = nullptr);

// Points no farther than `step` apart along the path, its own points included.
[[nodiscard]] std::vector<geometry::Vec2> with_points(const std::vector<geometry::Vec2>& path, double step);

}  // namespace cairn::ground
