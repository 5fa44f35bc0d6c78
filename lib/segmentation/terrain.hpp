// Surface and ground of a survey as grids.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "geometry/grid.hpp"
#include "geometry/vec.hpp"

namespace cairn::segmentation {

struct TerrainOptions {
  double cell_m = 0.25;       // edge of a cell
  double max_gap_m = 2.0;     // holes up to this width are interpolated (and marked); wider ones stay empty
  double spike_m = 0.5;       // a lone point that far from its cell's other points and all neighbours is no surface
  double max_object_m = 8.0;  // objects up to this width are taken off the ground
  double ground_slope = 0.1;  // allowance for curved ground, per metre of window growth (level slopes need none)
  double ground_tolerance_m = 0.15;  // height above the opened surface that is still ground, before slope
  double max_step_m = 2.5;           // and at most, with slope

  void visit(base::OptionVisitor& v) {
    v.real("cell-m", cell_m, 0.01, 100.0, "edge of a cell of the surface model, m");
    v.real("max-gap-m", max_gap_m, 0.0, 1000.0, "widest hole that is interpolated, m");
    v.real("spike-m", spike_m, 0.01, 1000.0, "how far a lone point may stand off its neighbours, m");
    v.real("max-object-m", max_object_m, 0.0, 500.0, "widest object that is taken off the ground, m");
    v.real("ground-slope", ground_slope, 0.0, 10.0, "allowance for curved ground, per metre that the window grows");
    v.real("ground-tolerance-m", ground_tolerance_m, 0.0, 10.0,
           "height above the opened surface that is still ground, m");
    v.real("max-step-m", max_step_m, 0.0, 100.0, "largest height above the opened surface that is still ground, m");
  }
};

// All grids of one geometry, whole cells of cell_m about the points.
struct TerrainModel {
  geometry::Grid<float> surface;          // local up of the highest points, m; NaN where nothing is known
  geometry::Grid<float> ground;           // local up of the bare ground, m, <= surface; NaN where surface is
  geometry::Grid<std::uint8_t> observed;  // 1: the surface comes from points of this cell; 0: interpolated or empty
  geometry::Grid<std::uint32_t> points;   // in each cell
  std::size_t not_finite = 0;             // points left out
  std::size_t spikes = 0;                 // cells whose highest point was not believed
  std::size_t interpolated = 0;           // cells with a surface and no observation
};

// points: local ENU, m.
//   surface: the highest point of a cell; a point more than spike_m above the cell's next point and above all observed
//     neighbours is replaced by that next one, or its cell left unobserved where it is the only one.
//   ground: the lowest points (guarded alike) opened by squares of growing width (progressive morphological filter,
//     Zhang et al. 2003, eq. 4 to 6): where the opening takes off more than tolerance + slope x growth of the window,
//     the cell and its neighbours are no ground; ground is interpolated there. Beyond the border heights are reflected
//     oddly, so that a slope goes on. First version: steep banks narrower than max_object_m
//     suffer, and objects wider than it stay.
//   holes: closed by max_gap_m (closed_mask) and filled by push-pull; never marked observed.
// Throws invalid_input where no point is finite, failed_precondition where the grid would pass 400 M cells.
// Cost linear in points and cells; 60 bytes a cell.
[[nodiscard]] TerrainModel model_terrain(std::span<const geometry::Vec3> points, const TerrainOptions& options,
                                         base::RunContext& ctx);

}  // namespace cairn::segmentation
