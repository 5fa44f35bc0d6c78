// An independent ray caster: every ray against every triangle, in double precision.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <optional>

#include "geometry/primitives.hpp"
#include "geometry/triangle_mesh.hpp"

namespace cairn::testing {

struct BruteForceHit {
  double distance = std::numeric_limits<double>::infinity();  // in lengths of the direction
  std::size_t triangle = 0;
  // Least barycentric coordinate at the hit: near zero the ray grazes an edge.
  double edge_clearance = 1.0;
};

// Moeller & Trumbore 1997, both sides. Empty where the ray misses.
inline std::optional<BruteForceHit> intersect(const geometry::TriangleMesh& mesh, std::size_t triangle,
                                              const geometry::Vec3& origin, const geometry::Vec3& direction) {
  const geometry::Triangle& t = mesh.triangles[triangle];
  const geometry::Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
  const geometry::Vec3 e1 = b - a, e2 = c - a;
  const geometry::Vec3 p = direction.cross(e2);
  const double det = e1.dot(p);
  if (!(std::abs(det) > 0.0)) return std::nullopt;
  const geometry::Vec3 s = origin - a;
  const double u = s.dot(p) / det;
  const geometry::Vec3 q = s.cross(e1);
  const double v = direction.dot(q) / det;
  const double w = 1.0 - u - v;
  const double distance = e2.dot(q) / det;
  if (!(u >= 0.0 && v >= 0.0 && w >= 0.0 && distance >= 0.0)) return std::nullopt;
  return BruteForceHit{distance, triangle, std::min({u, v, w})};
}

// First hit closer than `far` (in lengths of the direction).
inline std::optional<BruteForceHit> first_hit(const geometry::TriangleMesh& mesh, const geometry::Vec3& origin,
                                              const geometry::Vec3& direction,
                                              double far = std::numeric_limits<double>::infinity()) {
  std::optional<BruteForceHit> best;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto hit = intersect(mesh, i, origin, direction);
    if (hit && hit->distance < far && (!best || hit->distance < best->distance)) best = hit;
  }
  return best;
}

}  // namespace cairn::testing
