// Exact Euclidean distance to the nearest obstacle cell.
#pragma once

#include <cstdint>

#include "geometry/grid.hpp"

namespace cairn::ground {

// Squared distance between cell centres, in cells, to the nearest cell where obstacle != 0; values
// above reach^2 are replaced by reach^2 + 1 ("farther than reach").
// Exact in integers: two passes, columns then the lower envelope of parabolas along rows (Meijster,
// Roerdink & Hesselink 2000; Felzenszwalb & Huttenlocher 2012). Cost linear in cells; 4 bytes a cell
// for the result and 2 for the column pass. Results do not depend on threads.
// reach: cells, 1..32000.
[[nodiscard]] geometry::Grid<std::int32_t> squared_distance(const geometry::Grid<std::uint8_t>& obstacle, int reach);

}  // namespace cairn::ground
