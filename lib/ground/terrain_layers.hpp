// How easily ground can be driven: slope, roughness and steps of a height grid.
#pragma once

#include "base/options.hpp"
#include "geometry/grid.hpp"
#include "ground/occupancy.hpp"

namespace cairn::ground {

struct TerrainLayerOptions {
  double window_m = 0.7;         // edge of the square about a cell, of a vehicle's size; at least 3 x 3 cells
  double max_slope_deg = 20.0;   // traversability 0 from here on
  double max_roughness_m = 0.1;  // ...
  double max_step_m = 0.15;      // ...

  void visit(base::OptionVisitor& v) {
    v.real("terrain-window-m", window_m, 0.01, 100.0, "square about a cell for slope, roughness and steps");
    v.real("max-slope-deg", max_slope_deg, 0.1, 90.0, "slope that cannot be driven");
    v.real("max-roughness-m", max_roughness_m, 1e-4, 100.0, "roughness that cannot be driven");
    v.real("max-step-m", max_step_m, 1e-4, 100.0, "step that cannot be driven");
  }
};

// NaN where the height is not known, or fewer than three heights not on one line lie in the window.
struct TerrainLayers {
  geometry::Grid<float> slope_deg;       // of the least-squares plane of the window's heights
  geometry::Grid<float> roughness_m;     // root mean square of the heights about that plane
  geometry::Grid<float> step_m;          // largest difference of heights to one of the 8 neighbours
  geometry::Grid<float> traversability;  // 1 = level and smooth .. 0 = cannot be driven
};

// traversability = least of 1 - value / limit over the three, cut at 0 (after Chilian & Hirschmueller 2009, who add the
// weighted terms and cut where one passes its limit). Cost: cells times cells of the window; 16 bytes a cell.
[[nodiscard]] TerrainLayers terrain_layers(const geometry::Grid<float>& heights, const TerrainLayerOptions& options);

// Occupied where the traversability is 0, unknown where it is not known, else free.
[[nodiscard]] OccupancyGrid drivable(const TerrainLayers& layers);

}  // namespace cairn::ground
