#include "adjustment/cloud_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "geometry/primitives.hpp"

namespace cairn::adjustment {
namespace {

using geometry::Grid;
using geometry::Vec2;
using geometry::Vec3;

constexpr float kEmpty = std::numeric_limits<float>::quiet_NaN();

geometry::Box3 bounds(const geometry::PointCloud& cloud) {
  geometry::Box3 box;
  for (const auto& p : cloud.positions)
    if (p.allFinite()) box.extend(p);
  return box;
}

// Side of the square that one point would own, over the coarse cells that hold any.
double spacing(const geometry::PointCloud& cloud, const geometry::Box3& box) {
  constexpr std::size_t kSide = 128;
  const double cell = std::max({box.size().x(), box.size().y(), 1e-3}) / static_cast<double>(kSide);
  std::vector<char> used((kSide + 1) * (kSide + 1), 0);
  std::size_t points = 0;
  for (const auto& p : cloud.positions) {
    if (!p.allFinite()) continue;
    const auto c = static_cast<std::size_t>((p.x() - box.min.x()) / cell);
    const auto r = static_cast<std::size_t>((p.y() - box.min.y()) / cell);
    used[std::min(r, kSide) * (kSide + 1) + std::min(c, kSide)] = 1;
    ++points;
  }
  const auto cells = std::count(used.begin(), used.end(), char{1});
  return points == 0 ? 0.0 : std::sqrt(static_cast<double>(cells) * cell * cell / static_cast<double>(points));
}

void fill_once(Grid<float>& grid) {
  const auto rows = static_cast<std::ptrdiff_t>(grid.geometry.rows);
  const auto columns = static_cast<std::ptrdiff_t>(grid.geometry.columns);
  const Grid<float> before = grid;
  for (std::ptrdiff_t r = 0; r < rows; ++r)
    for (std::ptrdiff_t c = 0; c < columns; ++c) {
      const auto index = static_cast<std::size_t>(r * columns + c);
      if (!std::isnan(before.values[index])) continue;
      float sum = 0.0F;
      int count = 0;
      for (std::ptrdiff_t y = std::max<std::ptrdiff_t>(0, r - 1); y <= std::min(rows - 1, r + 1); ++y)
        for (std::ptrdiff_t x = std::max<std::ptrdiff_t>(0, c - 1); x <= std::min(columns - 1, c + 1); ++x) {
          const float v = before.values[static_cast<std::size_t>(y * columns + x)];
          if (std::isnan(v)) continue;
          sum += v;
          ++count;
        }
      // A single neighbour would let the border grow; two or more close holes and gaps.
      if (count >= 2) grid.values[index] = sum / static_cast<float>(count);
    }
}

}  // namespace

std::optional<double> CloudSurface::height_at(const Vec2& p) const {
  const auto& g = up_m.geometry;
  const double x = (p.x() - g.west) / g.cell - 0.5, y = (g.north - p.y()) / g.cell - 0.5;
  if (!(x >= 0.0 && y >= 0.0)) return std::nullopt;
  const auto c = static_cast<std::size_t>(x), r = static_cast<std::size_t>(y);
  if (c + 1 >= g.columns || r + 1 >= g.rows) return std::nullopt;
  const double u = x - static_cast<double>(c), v = y - static_cast<double>(r);
  const auto at = [&](std::size_t row, std::size_t column) { return static_cast<double>(up_m.at(row, column)); };
  const double value =
      (1.0 - v) * ((1.0 - u) * at(r, c) + u * at(r, c + 1)) + v * ((1.0 - u) * at(r + 1, c) + u * at(r + 1, c + 1));
  if (std::isnan(value)) return std::nullopt;
  return value;
}

CloudSurface cloud_surface(const geometry::PointCloud& cloud, double cell_m, int fill_rounds, std::size_t max_cells) {
  CloudSurface surface;
  const auto box = bounds(cloud);
  if (box.empty()) return surface;
  surface.point_spacing_m = spacing(cloud, box);
  constexpr double kSpacings = 1.3, kLeastCell = 0.05;
  double cell = cell_m > 0.0 ? cell_m : std::max(kLeastCell, kSpacings * surface.point_spacing_m);
  // Compared in doubles: an absurd extent must not overflow the count.
  while ((box.size().x() / cell + 2.0) * (box.size().y() / cell + 2.0) > static_cast<double>(max_cells)) cell *= 1.5;
  const auto geometry = geometry::covering_grid(box.min.head<2>(), box.max.head<2>() + Vec2::Constant(1e-6), cell);
  surface.up_m = Grid<float>(geometry, kEmpty);
  surface.brightness = Grid<float>(geometry, kEmpty);
  surface.coloured = cloud.colours.size() == cloud.size();
  std::uint16_t brightest = 0;
  if (surface.coloured)
    for (const auto& colour : cloud.colours) brightest = std::max({brightest, colour[0], colour[1], colour[2]});
  surface.coloured = surface.coloured && brightest > 0;
  // Many writers put 0..255 into the 16-bit fields.
  const double to_byte = brightest > 255 ? 255.0 / 65535.0 : 1.0;
  std::vector<double> up(geometry.cells(), 0.0), grey(geometry.cells(), 0.0);
  std::vector<std::uint32_t> count(geometry.cells(), 0);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vec3& p = cloud.positions[i];
    if (!p.allFinite()) continue;
    const auto at = geometry.cell_at(p.head<2>());
    if (!at) continue;
    const std::size_t index = at->first * geometry.columns + at->second;
    ++count[index];
    up[index] += p.z() - box.min.z();
    if (surface.coloured) {
      const auto& c = cloud.colours[i];
      grey[index] += to_byte * (0.299 * c[0] + 0.587 * c[1] + 0.114 * c[2]);
    }
  }
  for (std::size_t i = 0; i < count.size(); ++i) {
    if (count[i] == 0) continue;
    surface.up_m.values[i] = static_cast<float>(up[i] / count[i] + box.min.z());
    if (surface.coloured) surface.brightness.values[i] = static_cast<float>(grey[i] / count[i]);
  }
  for (int round = 0; round < fill_rounds; ++round) {
    fill_once(surface.up_m);
    if (surface.coloured) fill_once(surface.brightness);
  }
  return surface;
}

}  // namespace cairn::adjustment
