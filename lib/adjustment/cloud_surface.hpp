// A cloud seen from above: height and brightness on a grid.
#pragma once

#include <optional>

#include "geometry/grid.hpp"
#include "geometry/point_cloud.hpp"

namespace cairn::adjustment {

// Local ENU; NaN where the cloud has no point within the reach of the filling.
struct CloudSurface {
  geometry::Grid<float> up_m;        // highest-density height: mean of the cell's points
  geometry::Grid<float> brightness;  // 0..255 whatever the scale of the colours; all NaN without colours
  bool coloured = false;
  double point_spacing_m = 0.0;  // 1 / sqrt(points per area that holds points)

  // Bilinear; empty outside and next to empty cells.
  [[nodiscard]] std::optional<double> height_at(const geometry::Vec2& p) const;
};

// cell_m <= 0: 1.3 times the point spacing, at least 0.05 m. Cells without points are filled with the
// mean of their filled neighbours (8), `fill_rounds` times. Non-finite points are left out.
// A grid of more than max_cells is refused by coarsening the cell until it fits.
// Cost: linear in points and cells; 8 bytes a cell.
[[nodiscard]] CloudSurface cloud_surface(const geometry::PointCloud& cloud, double cell_m = 0.0, int fill_rounds = 3,
                                         std::size_t max_cells = 16'000'000);

}  // namespace cairn::adjustment
