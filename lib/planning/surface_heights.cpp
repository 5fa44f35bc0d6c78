#include "planning/surface_heights.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"

namespace cairn::planning {
namespace {

using geometry::Grid;
using geometry::GridGeometry;
using geometry::Vec2;
using geometry::Vec3;

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

// First and last (one beyond) of `count` cells that [low, high] touches, counted from `origin` upwards.
std::pair<std::size_t, std::size_t> span_of(double low, double high, double cell, std::size_t count) {
  const auto limit = static_cast<double>(count);
  const double first = std::clamp(std::floor(low / cell), 0.0, limit);
  const double last = std::clamp(std::floor(high / cell) + 1.0, first, limit);
  return {static_cast<std::size_t>(first), static_cast<std::size_t>(last)};
}

double distance_to(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 d = b - a;
  const double length = d.squaredNorm();
  const double t = length > 0.0 ? std::clamp((p - a).dot(d) / length, 0.0, 1.0) : 0.0;
  return (a + t * d - p).norm();
}

}  // namespace

Grid<float> highest_of(const geometry::TriangleMesh& mesh, double cell, std::size_t most_cells) {
  const auto sound = [&mesh](const geometry::Triangle& t) {
    return std::all_of(t.begin(), t.end(),
                       [&](std::uint32_t v) { return v < mesh.vertices.size() && mesh.vertices[v].allFinite(); });
  };
  geometry::Box3 box;
  for (const auto& t : mesh.triangles)
    if (sound(t))
      for (const std::uint32_t v : t) box.extend(mesh.vertices[v]);
  if (box.empty()) throw base::Error(base::ErrorCode::invalid_input, "the surface has no facets").allowed("at least 1");
  const Vec3 size = box.size();
  const double edge =
      std::max(cell, std::sqrt((size.x() + cell) * (size.y() + cell) / static_cast<double>(most_cells)));
  Grid<float> grid(geometry::covering_grid(box.min.head<2>(), box.max.head<2>(), edge), kUnknown);
  const GridGeometry& g = grid.geometry;
  for (const auto& t : mesh.triangles) {
    if (!sound(t)) continue;
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const Vec3 low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
    const Vec3 normal = (b - a).cross(c - a);
    const auto [c0, c1] = span_of(low.x() - g.west, high.x() - g.west, g.cell, g.columns);
    const auto [r0, r1] = span_of(g.north - high.y(), g.north - low.y(), g.cell, g.rows);
    // A facet within a cell or two needs no plane; an upright one has none.
    const bool flat = std::abs(normal.z()) > 1e-9 * normal.norm();
    for (std::size_t r = r0; r < r1; ++r)
      for (std::size_t col = c0; col < c1; ++col) {
        double z = high.z();
        if (flat) {
          const Vec2 m = g.centre(r, col);
          const double slope_e = -normal.x() / normal.z(), slope_n = -normal.y() / normal.z();
          const double plane = a.z() + slope_e * (m.x() - a.x()) + slope_n * (m.y() - a.y());
          z = std::min(z, plane + 0.5 * g.cell * (std::abs(slope_e) + std::abs(slope_n)));
          if (z < low.z()) continue;  // the cell lies beside the facet
        }
        float& value = grid.at(r, col);
        const auto up = static_cast<float>(z);
        value = std::isnan(value) ? up : std::max(value, up);
      }
  }
  return grid;
}

SurfaceHeights::SurfaceHeights(double level) : plane_(level), lowest_(level), highest_(level) {}

SurfaceHeights::SurfaceHeights(Grid<float> up) : up_(std::move(up)) {
  lowest_ = std::numeric_limits<double>::infinity();
  highest_ = -lowest_;
  for (const float v : up_.values) {
    if (std::isnan(v)) continue;
    lowest_ = std::min(lowest_, static_cast<double>(v));
    highest_ = std::max(highest_, static_cast<double>(v));
  }
  if (!(lowest_ <= highest_))
    throw base::Error(base::ErrorCode::invalid_input, "the surface holds no height").allowed("at least one cell");
}

std::optional<double> SurfaceHeights::up(const Vec2& p) const {
  if (plane_) return plane_;
  const auto cell = up_.geometry.cell_at(p);
  if (!cell || std::isnan(up_.at(cell->first, cell->second))) return std::nullopt;
  return static_cast<double>(up_.at(cell->first, cell->second));
}

template <typename Take>
void SurfaceHeights::visit(const Vec2& a, const Vec2& b, double radius, Take&& take) const {
  const GridGeometry& g = up_.geometry;
  const Vec2 low = a.cwiseMin(b), high = a.cwiseMax(b);
  const auto [c0, c1] = span_of(low.x() - radius - g.west, high.x() + radius - g.west, g.cell, g.columns);
  const auto [r0, r1] = span_of(g.north - high.y() - radius, g.north - low.y() + radius, g.cell, g.rows);
  const double reach = radius + g.cell * std::sqrt(0.5);
  for (std::size_t r = r0; r < r1; ++r)
    for (std::size_t c = c0; c < c1; ++c)
      if (!std::isnan(up_.at(r, c)) && distance_to(g.centre(r, c), a, b) <= reach)
        take(static_cast<double>(up_.at(r, c)));
}

std::optional<double> SurfaceHeights::highest(const Vec2& p, double radius) const {
  return highest(p, p, radius);
}

std::optional<double> SurfaceHeights::highest(const Vec2& a, const Vec2& b, double radius) const {
  if (plane_) return plane_;
  std::optional<double> most;
  visit(a, b, radius, [&most](double up) { most = most ? std::max(*most, up) : up; });
  return most;
}

std::optional<double> SurfaceHeights::quantile(const Vec2& p, double radius, double fraction) const {
  if (plane_) return plane_;
  std::vector<double> known;
  visit(p, p, radius, [&known](double up) { known.push_back(up); });
  if (known.empty()) return std::nullopt;
  const auto at = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(known.size() - 1));
  std::nth_element(known.begin(), known.begin() + at, known.end());
  return known[static_cast<std::size_t>(at)];
}

}  // namespace cairn::planning
