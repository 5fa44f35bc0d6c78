// Bare earth under a cloud, and which points stand out of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "geometry/grid.hpp"
#include "geometry/vec.hpp"

namespace cairn::segmentation {

struct GroundFilterOptions {
  double max_object_m = 6.0;   // objects up to this width are taken off the ground
  double cell_m = 0.0;         // edge of a cell; 0: the larger of max_object_m / object_cells and
  double object_cells = 40.0;  //   cell_spacings mean spacings of the points in plan
  double cell_spacings = 0.5;
  double object_slope = 0.25;  // what an opening of radius r cuts off by more than this times r is an object
  double tolerance_m = 0.0;    // height above level ground that is still ground; 0: tolerance_cells times the cell
  double tolerance_cells = 0.1;
  double tolerance_slope = 0.75;  // added to it: times cell times slope
  double roughness_factor = 0.5;  // added to it: times the ground's own roughness (a standard deviation)

  void visit(base::OptionVisitor& visitor);
};

enum class PointClass : std::uint8_t { unknown = 0, ground = 1, above = 2, below = 3 };

// The bare ground as heights at the centres of cells; complete over the grid.
struct GroundSurface {
  geometry::Grid<float> height;            // local up, m
  geometry::Grid<float> tolerance;         // height above (and below) it that is still ground, m
  geometry::Grid<std::uint8_t> is_ground;  // 1: ground was seen in this cell; 0: object, or no points: interpolated

  // Bilinear; beyond the outermost centres the height of the border. p: local ENU, m; finite.
  [[nodiscard]] double up(const geometry::Vec2& p) const;
  [[nodiscard]] double height_above(const geometry::Vec3& p) const { return p.z() - up(p.head<2>()); }
};

struct GroundFilterResult {
  GroundSurface surface;
  std::vector<PointClass> classes;  // one a point; unknown: not finite
  std::size_t ground = 0, above = 0, below = 0, not_finite = 0;
};

// Grid that `options` give for points of this number between these corners (m, plan); every part of a cloud that is
// filtered by itself must stand on it. Throws failed_precondition where it would pass 400 M cells.
[[nodiscard]] geometry::GridGeometry ground_grid(const geometry::Vec2& low, const geometry::Vec2& high,
                                                 std::uint64_t count, const GroundFilterOptions& options);

// points: local ENU, m; any order, any density.
//   1. lowest point and mean of each cell; lone pits are dropped, empty cells filled (push-pull);
//   2. progressive opening by squares of growing radius r up to max_object_m / 2; what one step cuts off by more than
//      object_slope r is an object (Zhang et al. 2003; threshold of Pingel, Clarke & McBride 2013, SMRF);
//      beyond the border heights are reflected oddly, so that slopes go on;
//   3. heights of ground cells, interpolated under objects; tolerance = tolerance_m + tolerance_slope cell slope
//      + roughness_factor roughness (SMRF's, with roughness from second differences of ground cells);
//   4. each point against the bilinear surface.
// All lengths without unit options scale with the cell, so that one set serves a boulder field at 3 cm spacing and an
// airborne survey at 2 m. Grid aligned to multiples of the cell.
// Throws invalid_input where no point is finite, failed_precondition where the grid would pass 400 M cells.
// Cost linear in points and cells; 1 byte a point and about 40 bytes a cell.
[[nodiscard]] GroundFilterResult filter_ground(std::span<const geometry::Vec3> points,
                                               const GroundFilterOptions& options, base::RunContext& ctx);

// The same on a grid that is given: a part of a larger cloud. Points outside take part at the nearest border cell.
[[nodiscard]] GroundFilterResult filter_ground(std::span<const geometry::Vec3> points,
                                               const geometry::GridGeometry& grid, const GroundFilterOptions& options,
                                               base::RunContext& ctx);

}  // namespace cairn::segmentation
