// Small shapes that are plain data.
#pragma once

#include <limits>
#include <vector>

#include "geometry/vec.hpp"

namespace cairn::geometry {

// Half-line: origin + s * direction, s >= 0. The direction is of unit length.
struct Ray {
  Vec3 origin = Vec3::Zero();
  Vec3 direction = Vec3::UnitZ();
};

// Axis-aligned box of pixels in the raw (un-rotated) image, corner convention: the first
// pixel spans 0..1, its centre is (0.5, 0.5).
struct PixelBox {
  double xmin = 0.0, ymin = 0.0, xmax = 0.0, ymax = 0.0;

  [[nodiscard]] double width() const { return xmax - xmin; }
  [[nodiscard]] double height() const { return ymax - ymin; }
  [[nodiscard]] double area() const { return width() * height(); }
  [[nodiscard]] Vec2 centre() const { return {0.5 * (xmin + xmax), 0.5 * (ymin + ymax)}; }
  [[nodiscard]] bool contains(const Vec2& p) const {
    return p.x() >= xmin && p.x() <= xmax && p.y() >= ymin && p.y() <= ymax;
  }
  friend bool operator==(const PixelBox&, const PixelBox&) = default;
};

// Axis-aligned box in metres; empty until extended.
struct Box3 {
  Vec3 min = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 max = Vec3::Constant(-std::numeric_limits<double>::infinity());

  [[nodiscard]] bool empty() const { return !(min.x() <= max.x()); }
  void extend(const Vec3& p) {
    min = min.cwiseMin(p);
    max = max.cwiseMax(p);
  }
  [[nodiscard]] Vec3 size() const { return empty() ? Vec3(Vec3::Zero()) : Vec3(max - min); }
  [[nodiscard]] Vec3 centre() const { return 0.5 * (min + max); }
};

// Upright cylinder: the bounding cylinder of paper A (A23).
struct VerticalCylinder {
  Vec2 axis = Vec2::Zero();  // east, north of the axis, m
  double bottom = 0.0;       // up of the lower and upper disc, m, bottom <= top
  double top = 0.0;
  double radius = 0.0;  // m, >= 0

  [[nodiscard]] double height() const { return top - bottom; }
  [[nodiscard]] Vec3 centre() const { return {axis.x(), axis.y(), 0.5 * (bottom + top)}; }
};

// Ring of vertices without a repeated last one. Counter-clockwise = positive area.
using Ring = std::vector<Vec2>;

[[nodiscard]] double signed_area(const Ring& ring);
// Even-odd rule; points on the border may fall on either side.
[[nodiscard]] bool contains(const Ring& ring, const Vec2& p);
// Convex hull (Andrew's monotone chain), counter-clockwise, collinear points dropped.
// Cost n log n. Fewer than 3 distinct points give that many vertices.
[[nodiscard]] Ring convex_hull(std::vector<Vec2> points);

}  // namespace cairn::geometry
