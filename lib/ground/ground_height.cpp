#include "ground/ground_height.hpp"

#include <algorithm>
#include <cmath>

namespace cairn::ground {

using geometry::Vec3;

double Ground::up(double east, double north) const {
  if (terrain)
    if (const auto height = terrain(east, north); height && std::isfinite(*height)) return *height;
  return plane_up;
}

bool Ground::known(double east, double north) const {
  if (!terrain) return false;
  const auto height = terrain(east, north);
  return height && std::isfinite(*height);
}

std::optional<GroundHit> cast_on_ground(const geometry::Ray& ray, const Ground& ground, double above, double max_range,
                                        double step) {
  if (!ground.terrain) {
    const double range = (ground.plane_up + above - ray.origin.z()) / ray.direction.z();
    if (!std::isfinite(range) || range <= 0.0 || range > max_range || !(ray.direction.z() < 0.0)) return std::nullopt;
    return GroundHit{ray.origin + range * ray.direction, range, false};
  }
  const auto clearance = [&](double range) {
    const Vec3 p = ray.origin + range * ray.direction;
    return p.z() - above - ground.up(p.x(), p.y());
  };
  double above_ground = clearance(0.0);
  if (!(above_ground > 0.0)) return std::nullopt;
  double before = 0.0;
  while (before < max_range) {
    const double after = std::min(before + std::max(step, 0.25 * above_ground), max_range);
    if (const double here = clearance(after); here > 0.0) {
      before = after;
      above_ground = here;
      continue;
    }
    double low = before, high = after;
    constexpr double kExact = 1e-9;  // m
    while (high - low > kExact) {
      const double middle = 0.5 * (low + high);
      (clearance(middle) > 0.0 ? low : high) = middle;
    }
    const Vec3 p = ray.origin + high * ray.direction;
    return GroundHit{p, high, ground.known(p.x(), p.y())};
  }
  return std::nullopt;
}

}  // namespace cairn::ground
