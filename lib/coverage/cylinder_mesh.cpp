#include "coverage/cylinder_mesh.hpp"

#include <cmath>
#include <numbers>

namespace cairn::coverage {
namespace {

using geometry::Vec2;
using geometry::Vec3;

Vec2 on_circle(const Vec2& axis, double radius, double sector) {
  const double azimuth = 2.0 * std::numbers::pi * sector / static_cast<double>(kSectors);
  return axis + radius * Vec2(std::sin(azimuth), std::cos(azimuth));
}

}  // namespace

geometry::TriangleMesh cylinder_mesh(const geometry::VerticalCylinder& c) {
  geometry::TriangleMesh mesh;
  const auto corner = [](std::size_t ring, std::size_t sector) {
    return static_cast<std::uint32_t>(ring * kSectors + sector % kSectors);
  };
  for (std::size_t row = 0; row <= kWallRows; ++row)
    for (std::size_t s = 0; s < kSectors; ++s) {
      const Vec2 p = on_circle(c.axis, c.radius, static_cast<double>(s));
      mesh.vertices.emplace_back(p.x(), p.y(),
                                 c.bottom + c.height() * static_cast<double>(row) / static_cast<double>(kWallRows));
    }
  // Azimuths run clockwise seen from above, so the next sector stands to the left of one who looks at the wall.
  for (std::size_t row = 0; row < kWallRows; ++row)
    for (std::size_t s = 0; s < kSectors; ++s) {
      const std::uint32_t a = corner(row, s), b = corner(row, s + 1), d = corner(row + 1, s),
                          e = corner(row + 1, s + 1);
      mesh.triangles.push_back({a, d, b});
      mesh.triangles.push_back({b, d, e});
    }
  // The top's outer ring is the wall's upper edge; the inner ones follow, then the middle.
  const auto ring = [&](std::size_t k, std::size_t s) {  // k = 1 .. kTopRings from the axis
    return k == kTopRings ? corner(kWallRows, s) : corner(kWallRows + 1 + (k - 1), s);
  };
  for (std::size_t k = 1; k < kTopRings; ++k)
    for (std::size_t s = 0; s < kSectors; ++s) {
      const Vec2 p =
          on_circle(c.axis, c.radius * static_cast<double>(k) / static_cast<double>(kTopRings), static_cast<double>(s));
      mesh.vertices.emplace_back(p.x(), p.y(), c.top);
    }
  const auto middle = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.emplace_back(c.axis.x(), c.axis.y(), c.top);
  for (std::size_t s = 0; s < kSectors; ++s) mesh.triangles.push_back({middle, ring(1, s + 1), ring(1, s)});
  for (std::size_t k = 1; k < kTopRings; ++k)
    for (std::size_t s = 0; s < kSectors; ++s) {
      mesh.triangles.push_back({ring(k, s), ring(k + 1, s + 1), ring(k + 1, s)});
      mesh.triangles.push_back({ring(k, s), ring(k, s + 1), ring(k + 1, s + 1)});
    }
  return mesh;
}

Vec2 sector_point(const Vec2& axis, double radius, std::size_t sector) {
  return on_circle(axis, radius, static_cast<double>(sector) + 0.5);
}

}  // namespace cairn::coverage
