// The ground around one rock, as a plane.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "geometry/vec.hpp"

namespace cairn::segmentation {

// up = up_at_centre + slope . (p - centre), all m, local ENU.
struct GroundPlane {
  geometry::Vec2 centre = geometry::Vec2::Zero();
  double up_at_centre = 0.0;
  geometry::Vec2 slope = geometry::Vec2::Zero();  // rise per metre east, north
  double noise = 0.0;                             // robust standard deviation of the points about the plane, m
  std::size_t points = 0;                         // points offered
  std::size_t sectors = 0;                        // of 8 around the centre: those with points

  [[nodiscard]] double up(const geometry::Vec2& p) const { return up_at_centre + slope.dot(p - centre); }
  [[nodiscard]] double height_above(const geometry::Vec3& p) const { return p.z() - up(p.head<2>()); }
};

// Plane through the ground among `points` (an annulus around a rock; bushes and other rocks may stand in it).
// Start: least squares through the lowest point of each patch (8 sectors x 3 rings); then reweighted
// least squares with Cauchy weights (scale 2 x 1.4826 MAD), 20 rounds. Holds while most of the patches show ground
// somewhere. Empty with fewer than 3 patches or points on a line. Cost linear.
[[nodiscard]] std::optional<GroundPlane> fit_ground(std::span<const geometry::Vec3> points,
                                                    const geometry::Vec2& centre);

}  // namespace cairn::segmentation
