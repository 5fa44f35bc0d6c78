#include "geometry/primitives.hpp"

#include <algorithm>

namespace cairn::geometry {
namespace {

double cross(const Vec2& o, const Vec2& a, const Vec2& b) {
  return (a.x() - o.x()) * (b.y() - o.y()) - (a.y() - o.y()) * (b.x() - o.x());
}

}  // namespace

double signed_area(const Ring& ring) {
  if (ring.size() < 3) return 0.0;
  // Relative to the first vertex: coordinates of a projected CRS would cancel badly.
  double sum = 0.0;
  for (std::size_t i = 1; i + 1 < ring.size(); ++i) sum += cross(ring[0], ring[i], ring[i + 1]);
  return 0.5 * sum;
}

bool contains(const Ring& ring, const Vec2& p) {
  bool inside = false;
  for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
    const Vec2& a = ring[i];
    const Vec2& b = ring[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x())
      inside = !inside;
  }
  return inside;
}

Ring convex_hull(std::vector<Vec2> points) {
  std::sort(points.begin(), points.end(),
            [](const Vec2& a, const Vec2& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  Ring hull;
  const auto grow = [&hull](const Vec2& p, std::size_t base) {
    while (hull.size() >= base + 2 && cross(hull[hull.size() - 2], hull.back(), p) <= 0.0) hull.pop_back();
    hull.push_back(p);
  };
  for (const auto& p : points) grow(p, 0);
  const std::size_t lower = hull.size() - 1;
  hull.pop_back();
  for (auto p = points.rbegin(); p != points.rend(); ++p) grow(*p, lower);
  hull.pop_back();
  return hull;
}

}  // namespace cairn::geometry
