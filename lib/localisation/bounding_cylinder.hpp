// The upright cylinder that bounds a target's points.
#pragma once

#include "geometry/primitives.hpp"
#include "localisation/points.hpp"

namespace cairn::localisation {

// Paper A, A23: H1 intersected with H2, both about the vertical through the mean of the points.
// H1 is the smallest that holds all points; H2 has height 6 sigma_z and radius 3 max(sigma_x, sigma_y).
// Precondition: at least one point.
[[nodiscard]] geometry::VerticalCylinder bounding_cylinder(const Points& points);

}  // namespace cairn::localisation
