#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "camera/projection.hpp"
#include "geometry/primitives.hpp"
#include "planning/lawnmower.hpp"

namespace cairn::planning {

using geometry::Vec2;
using geometry::Vec3;

OverlapFigures count_overlap(const Area& area, const std::vector<survey::Frame>& views, const survey::Camera& camera,
                             const SurfaceHeights& surface, double step) {
  constexpr double kMostPoints = 2e6;
  geometry::Box3 box;
  for (const auto& ring : area)
    for (const Vec2& p : ring) box.extend({p.x(), p.y(), 0.0});
  const Vec3 size = box.size();
  step = std::max(step, std::sqrt(size.x() * size.y() / kMostPoints));
  const auto columns = static_cast<std::size_t>(std::ceil(size.x() / step)) + 1;
  const auto rows = static_cast<std::size_t>(std::ceil(size.y() / step)) + 1;
  const auto point = [&](std::size_t r, std::size_t c) {
    return Vec2(std::min(box.min.x() + step * static_cast<double>(c), box.max.x()),
                std::min(box.min.y() + step * static_cast<double>(r), box.max.y()));
  };
  constexpr std::int32_t kOutside = -1;
  std::vector<std::int32_t> count(rows * columns, kOutside);
  std::vector<double> up(rows * columns, 0.0);
  OverlapFigures figures;
  double lowest = std::numeric_limits<double>::infinity();
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t c = 0; c < columns; ++c) {
      if (!inside(area, point(r, c))) continue;
      const auto height = surface.up(point(r, c));
      if (!height) {
        ++figures.unknown;
        continue;
      }
      count[r * columns + c] = 0;
      up[r * columns + c] = *height;
      lowest = std::min(lowest, *height);
      ++figures.points;
    }
  double highest_view = -std::numeric_limits<double>::infinity();
  for (const survey::Frame& view : views) {
    const Vec3 at = view.T_world_camera.translation;
    highest_view = std::max(highest_view, at.z());
    const geometry::Ring print = camera::footprint(camera, view.T_world_camera, lowest);
    if (print.empty()) continue;
    // What stands higher is seen between the camera and its footprint on the lowest plane.
    Vec2 low = at.head<2>(), high = low;
    for (const Vec2& p : print) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    const auto index = [step](double offset, std::size_t most, bool ceil) {
      const double i = ceil ? std::ceil(offset / step) : std::floor(offset / step) + 1.0;
      return static_cast<std::size_t>(std::clamp(i, 0.0, static_cast<double>(most)));
    };
    const std::size_t c0 = index(low.x() - box.min.x(), columns, true),
                      c1 = index(high.x() - box.min.x() + step, columns, false);
    const std::size_t r0 = index(low.y() - box.min.y(), rows, true),
                      r1 = index(high.y() - box.min.y() + step, rows, false);
    for (std::size_t r = r0; r < r1; ++r)
      for (std::size_t c = c0; c < c1; ++c) {
        std::int32_t& n = count[r * columns + c];
        if (n == kOutside) continue;
        const Vec2 p = point(r, c);
        const auto pixel = camera::project_world(camera, view.T_world_camera, {p.x(), p.y(), up[r * columns + c]});
        if (pixel && camera::inside_image(camera, *pixel)) ++n;
      }
  }
  std::vector<std::int32_t> seen;
  for (const std::int32_t n : count)
    if (n != kOutside) seen.push_back(n);
  if (seen.empty()) return figures;
  std::sort(seen.begin(), seen.end());
  figures.uncovered = static_cast<std::size_t>(std::upper_bound(seen.begin(), seen.end(), 0) - seen.begin());
  figures.least = static_cast<std::size_t>(seen.front());
  figures.first_percentile = static_cast<std::size_t>(seen[seen.size() / 100]);
  figures.median = static_cast<std::size_t>(seen[seen.size() / 2]);
  figures.coarsest_gsd_m = (highest_view - lowest) / std::sqrt(camera.fx_px * camera.fy_px);
  return figures;
}

}  // namespace cairn::planning
