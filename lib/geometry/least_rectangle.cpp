#include "geometry/least_rectangle.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include "base/angle.hpp"
#include "geometry/primitives.hpp"

namespace cairn::geometry {

PlanRectangle least_area_rectangle(std::span<const Vec2> points) {
  PlanRectangle best;
  if (points.empty()) return best;
  const Vec2 origin = points.front();
  std::vector<Vec2> local;
  local.reserve(points.size());
  for (const auto& p : points) local.push_back(p - origin);
  const Ring hull = convex_hull(local);
  best.centre = points.front();
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < hull.size() && hull.size() > 1; ++i) {
    const Vec2 along = (hull[(i + 1) % hull.size()] - hull[i]).normalized();
    const Vec2 across(-along.y(), along.x());
    Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (const auto& p : hull) {
      const Vec2 q(p.dot(along), p.dot(across));
      low = low.cwiseMin(q);
      high = high.cwiseMax(q);
    }
    const Vec2 size = high - low;
    if (!(size.prod() < least)) continue;
    least = size.prod();
    const Vec2 middle = 0.5 * (low + high);
    best.centre = origin + middle.x() * along + middle.y() * across;
    best.length = size.maxCoeff();
    best.width = size.minCoeff();
    const Vec2& longer = size.x() >= size.y() ? along : across;
    best.length_azimuth_deg = std::fmod(base::azimuth_deg(longer.x(), longer.y()), 180.0);
  }
  return best;
}

}  // namespace cairn::geometry
