// Height of the ground as a function, and where a line of sight meets it.
#pragma once

#include <functional>
#include <optional>

#include "geometry/primitives.hpp"

namespace cairn::ground {

// Height of the bare ground [local up, m] at (east, north); empty where it is not known.
using GroundHeight = std::function<std::optional<double>(double east, double north)>;

// Ground that is known everywhere: the terrain where it is known, the horizontal plane elsewhere.
struct Ground {
  GroundHeight terrain;   // may be empty: then the plane alone
  double plane_up = 0.0;  // local up, m

  [[nodiscard]] double up(double east, double north) const;
  [[nodiscard]] bool known(double east, double north) const;
};

struct GroundHit {
  geometry::Vec3 point = geometry::Vec3::Zero();  // on the ground raised by `above`, local ENU, m
  double range = 0.0;                             // from the ray's origin, m
  bool on_terrain = false;                        // false: the plane stood in for it
};

// First point at which a ray goes under the ground raised by `above` [m]. Marches in steps of a quarter of its
// height above the ground, at least `step` [m], then halves the step that crossed (to 1e-9 m); slopes beyond 75 deg
// that are lower than the ray's height may be stepped over. A plane alone is met exactly. Empty where the ray does not
// meet it within max_range [m], or starts below it. Cost: some 10 to 100 evaluations of the terrain.
[[nodiscard]] std::optional<GroundHit> cast_on_ground(const geometry::Ray& ray, const Ground& ground, double above,
                                                      double max_range, double step);

}  // namespace cairn::ground
