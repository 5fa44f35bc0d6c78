// The rectangle of least area around points in plan.
#pragma once

#include <span>

#include "geometry/vec.hpp"

namespace cairn::geometry {

struct PlanRectangle {
  Vec2 centre = Vec2::Zero();
  double length = 0.0, width = 0.0;  // m, length >= width
  double length_azimuth_deg = 0.0;   // of the longer side, clockwise from +y (north), 0 <= a < 180
};

// One side lies on a side of the convex hull (Freeman & Shapira 1975), so each is tried; ties go to the first
// hull side. Fewer than 3 distinct points, or points on a line: width 0. No points: all zero. Cost n log n + h^2.
[[nodiscard]] PlanRectangle least_area_rectangle(std::span<const Vec2> points);

}  // namespace cairn::geometry
