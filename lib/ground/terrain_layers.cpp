#include "ground/terrain_layers.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/angle.hpp"
#include "base/parallel.hpp"

namespace cairn::ground {
namespace {

using geometry::Grid;

// Sums over the known heights of a window; offsets in cells, heights from the middle one.
struct PlaneSums {
  double n = 0.0, x = 0.0, y = 0.0, z = 0.0, xx = 0.0, xy = 0.0, yy = 0.0, xz = 0.0, yz = 0.0, zz = 0.0;

  void add(double dx, double dy, double dz) {
    n += 1.0;
    x += dx;
    y += dy;
    z += dz;
    xx += dx * dx;
    xy += dx * dy;
    yy += dy * dy;
    xz += dx * dz;
    yz += dy * dz;
    zz += dz * dz;
  }
};

struct Plane {
  double gradient = 0.0;  // rise per cell
  double rms = 0.0;       // of the heights about it, m
  bool determined = false;
};

Plane fit(const PlaneSums& s) {
  if (s.n < 3.0) return {};
  const double xx = s.xx - s.x * s.x / s.n, xy = s.xy - s.x * s.y / s.n, yy = s.yy - s.y * s.y / s.n;
  const double xz = s.xz - s.x * s.z / s.n, yz = s.yz - s.y * s.z / s.n, zz = s.zz - s.z * s.z / s.n;
  const double determinant = xx * yy - xy * xy;
  if (!(determinant > 1e-9 * std::max(1.0, xx * yy))) return {};
  const double a = (xz * yy - yz * xy) / determinant, b = (yz * xx - xz * xy) / determinant;
  const double residual = std::max(0.0, zz - a * xz - b * yz);
  return {std::hypot(a, b), std::sqrt(residual / s.n), true};
}

}  // namespace

TerrainLayers terrain_layers(const Grid<float>& heights, const TerrainLayerOptions& options) {
  TerrainLayerOptions checked = options;
  base::validate(base::bind_options(checked), "terrain layers");
  const auto& g = heights.geometry;
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const Grid<float> none(g, kNan);
  TerrainLayers out{none, none, none, none};
  const auto half = static_cast<std::size_t>(std::max(1.0, std::round(0.5 * options.window_m / g.cell)));
  base::parallel_for(g.rows, 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r)
      for (std::size_t c = 0; c < g.columns; ++c) {
        const float here = heights.at(r, c);
        if (!std::isfinite(here)) continue;
        PlaneSums sums;
        double step = 0.0;
        const CellRegion near = widened({r, c, 1, 1}, half, g);
        for (std::size_t i = near.row; i < near.end_row(); ++i)
          for (std::size_t j = near.column; j < near.end_column(); ++j) {
            const float there = heights.at(i, j);
            if (!std::isfinite(there)) continue;
            const double dz = static_cast<double>(there) - static_cast<double>(here);
            const double dx = static_cast<double>(j) - static_cast<double>(c);
            const double dy = static_cast<double>(r) - static_cast<double>(i);
            sums.add(dx, dy, dz);
            if (std::abs(dx) <= 1.0 && std::abs(dy) <= 1.0) step = std::max(step, std::abs(dz));
          }
        const Plane plane = fit(sums);
        if (!plane.determined) continue;
        const double slope = base::rad_to_deg(std::atan(plane.gradient / g.cell));
        const double least = std::min({1.0 - slope / options.max_slope_deg, 1.0 - plane.rms / options.max_roughness_m,
                                       1.0 - step / options.max_step_m});
        out.slope_deg.at(r, c) = static_cast<float>(slope);
        out.roughness_m.at(r, c) = static_cast<float>(plane.rms);
        out.step_m.at(r, c) = static_cast<float>(step);
        out.traversability.at(r, c) = static_cast<float>(std::max(0.0, least));
      }
  });
  return out;
}

OccupancyGrid drivable(const TerrainLayers& layers) {
  OccupancyGrid grid(layers.traversability.geometry, Occupancy::unknown);
  for (std::size_t i = 0; i < grid.values.size(); ++i) {
    const float value = layers.traversability.values[i];
    if (std::isfinite(value)) grid.values[i] = value > 0.0F ? Occupancy::free : Occupancy::occupied;
  }
  return grid;
}

}  // namespace cairn::ground
