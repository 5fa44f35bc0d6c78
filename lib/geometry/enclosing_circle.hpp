// Smallest circle around points of the plane.
#pragma once

#include <vector>

#include "geometry/vec.hpp"

namespace cairn::geometry {

struct Circle {
  Vec2 centre = Vec2::Zero();
  double radius = 0.0;  // m, >= 0
};

// Exact but for rounding: every point lies within radius (1 + 1e-12). No points: radius 0 at the origin.
// Source: E. Welzl, "Smallest enclosing disks (balls and ellipsoids)", 1991, in its iterative form over the
// convex hull. Cost n log n for the hull, expected linear in its vertices.
[[nodiscard]] Circle smallest_enclosing_circle(const std::vector<Vec2>& points);

}  // namespace cairn::geometry
