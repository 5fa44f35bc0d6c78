// The area to survey: its checks, and what of it lies in a strip.
#pragma once

#include <utility>
#include <vector>

#include "geometry/primitives.hpp"

namespace cairn::planning {

// Local east, north, m. Any number of outer rings and holes, in any order and direction: inside is what an odd number
// of rings encloses.
using Area = std::vector<geometry::Ring>;

// Throws invalid_input naming ring and edges where a ring has fewer than 3 distinct vertices, a vertex that is not
// finite, no area, or crosses or touches itself. Cost n^2 in a ring's edges; 20 000 vertices at most.
void check_area(const Area& area);

// Even-odd rule; points on the border may fall on either side.
[[nodiscard]] bool inside(const Area& area, const geometry::Vec2& p);

// Along-track extents of the part of the area whose across-track coordinate lies in [low, high]. Coordinates: along =
// p . (sin a, cos a) for the azimuth a [rad, clockwise from north], across = p . (cos a, -sin a). Disjoint, ascending.
[[nodiscard]] std::vector<std::pair<double, double>> strip_extents(const Area& area, double azimuth, double low,
                                                                   double high);

// Lowest and highest across-track coordinate.
[[nodiscard]] std::pair<double, double> across_range(const Area& area, double azimuth);

// Azimuth [rad, 0..pi) of lanes along which the area is narrowest: least number of turns. Along an edge of its hull.
[[nodiscard]] double narrowest_azimuth(const Area& area);

}  // namespace cairn::planning
