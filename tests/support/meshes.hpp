// Small meshes for tests.
#pragma once

#include <cmath>
#include <cstdint>
#include <string_view>

#include "base/random.hpp"
#include "geometry/triangle_mesh.hpp"

namespace cairn::testing {

// Triangles thrown at random into a cube of edge `size` [m] about `centre`.
inline geometry::TriangleMesh triangle_soup(std::size_t count, double size, double edge, const geometry::Vec3& centre,
                                            std::uint64_t seed) {
  base::Random random(seed, "triangle_soup", 0);
  const auto vec = [&random](double half) {
    return geometry::Vec3(random.uniform(-half, half), random.uniform(-half, half), random.uniform(-half, half));
  };
  geometry::TriangleMesh mesh;
  for (std::size_t i = 0; i < count; ++i) {
    const geometry::Vec3 at = centre + vec(0.5 * size);
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (int k = 0; k < 3; ++k) mesh.vertices.push_back(at + vec(edge));
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

// Axis-aligned rectangle at height z, facing up, cells x cells squares of two triangles each.
inline geometry::TriangleMesh slab(double xmin, double ymin, double xmax, double ymax, double z, std::uint32_t cells) {
  geometry::TriangleMesh mesh;
  for (std::uint32_t j = 0; j <= cells; ++j)
    for (std::uint32_t i = 0; i <= cells; ++i)
      mesh.vertices.emplace_back(xmin + (xmax - xmin) * i / cells, ymin + (ymax - ymin) * j / cells, z);
  const std::uint32_t row = cells + 1;
  for (std::uint32_t j = 0; j < cells; ++j)
    for (std::uint32_t i = 0; i < cells; ++i) {
      const std::uint32_t a = j * row + i;
      mesh.triangles.push_back({a, a + 1, a + row});
      mesh.triangles.push_back({a + 1, a + row + 1, a + row});
    }
  return mesh;
}

// Closed sphere by latitude and longitude, outward.
inline geometry::TriangleMesh sphere(const geometry::Vec3& centre, double radius, std::uint32_t rings) {
  constexpr double kPi = 3.14159265358979323846;
  geometry::TriangleMesh mesh;
  const std::uint32_t sectors = 2 * rings;
  mesh.vertices.push_back(centre + geometry::Vec3(0, 0, radius));
  for (std::uint32_t r = 1; r < rings; ++r)
    for (std::uint32_t s = 0; s < sectors; ++s) {
      const double polar = kPi * r / rings, azimuth = 2 * kPi * s / sectors;
      mesh.vertices.push_back(centre + radius * geometry::Vec3(std::sin(polar) * std::cos(azimuth),
                                                               std::sin(polar) * std::sin(azimuth), std::cos(polar)));
    }
  mesh.vertices.push_back(centre - geometry::Vec3(0, 0, radius));
  const auto last = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  const auto at = [sectors](std::uint32_t r, std::uint32_t s) { return 1 + (r - 1) * sectors + s % sectors; };
  for (std::uint32_t s = 0; s < sectors; ++s) {
    mesh.triangles.push_back({0, at(1, s), at(1, s + 1)});
    mesh.triangles.push_back({last, at(rings - 1, s + 1), at(rings - 1, s)});
    for (std::uint32_t r = 1; r + 1 < rings; ++r) {
      mesh.triangles.push_back({at(r, s), at(r + 1, s), at(r + 1, s + 1)});
      mesh.triangles.push_back({at(r, s), at(r + 1, s + 1), at(r, s + 1)});
    }
  }
  return mesh;
}

// Closed axis-aligned box of 12 triangles, outward.
inline geometry::TriangleMesh box(const geometry::Vec3& lo, const geometry::Vec3& hi) {
  geometry::TriangleMesh mesh;
  for (std::uint32_t i = 0; i < 8; ++i)
    mesh.vertices.emplace_back((i & 1U) != 0 ? hi.x() : lo.x(), (i & 2U) != 0 ? hi.y() : lo.y(),
                               (i & 4U) != 0 ? hi.z() : lo.z());
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

// Both meshes side by side.
inline geometry::TriangleMesh joined(geometry::TriangleMesh a, const geometry::TriangleMesh& b) {
  const auto offset = static_cast<std::uint32_t>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const geometry::Triangle& t : b.triangles) a.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  return a;
}

}  // namespace cairn::testing
