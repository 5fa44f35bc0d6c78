#include "planning/cylinder_surface.hpp"

#include <cmath>
#include <numbers>

namespace cairn::planning {

CylinderSurface cylinder_surface(const geometry::VerticalCylinder& cylinder, std::size_t sectors, std::size_t rows,
                                 std::size_t rings) {
  CylinderSurface surface;
  auto& mesh = surface.mesh;
  const auto ring_of = [&](double radius, double up) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (std::size_t s = 0; s < sectors; ++s) {
      const double a = 2.0 * std::numbers::pi * static_cast<double>(s) / static_cast<double>(sectors);
      mesh.vertices.emplace_back(cylinder.axis.x() + radius * std::cos(a), cylinder.axis.y() + radius * std::sin(a),
                                 up);
    }
    return first;
  };
  // Between two rings, counter-clockwise seen from above: outward where `lower` lies below or outside `upper`.
  const auto band = [&](std::uint32_t lower, std::uint32_t upper) {
    const auto n = static_cast<std::uint32_t>(sectors);
    for (std::uint32_t s = 0; s < n; ++s) {
      const std::uint32_t t = (s + 1) % n;
      mesh.triangles.push_back({lower + s, lower + t, upper + t});
      mesh.triangles.push_back({lower + s, upper + t, upper + s});
    }
  };
  std::uint32_t below = ring_of(cylinder.radius, cylinder.bottom);
  for (std::size_t r = 1; r <= rows; ++r) {
    const auto above = ring_of(
        cylinder.radius, cylinder.bottom + cylinder.height() * static_cast<double>(r) / static_cast<double>(rows));
    band(below, above);
    below = above;
  }
  surface.side_facets = mesh.triangles.size();
  for (std::size_t r = rings; r-- > 1;) {
    const auto within = ring_of(cylinder.radius * static_cast<double>(r) / static_cast<double>(rings), cylinder.top);
    band(below, within);
    below = within;
  }
  const auto middle = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.emplace_back(cylinder.axis.x(), cylinder.axis.y(), cylinder.top);
  for (std::uint32_t s = 0; s < static_cast<std::uint32_t>(sectors); ++s)
    mesh.triangles.push_back({below + s, below + (s + 1) % static_cast<std::uint32_t>(sectors), middle});
  return surface;
}

}  // namespace cairn::planning
