// Objects as what openings by growing windows cut off.
#pragma once

#include <cstdint>

#include "geometry/grid.hpp"

namespace cairn::segmentation {

// 1 where, for some radius r, the opening by a square of 2 r + 1 cells lies below the opening by the radius before it
// by more than step_allowance, where r runs to `radius` and step_allowance = slope r cell (m, slope in m per m).
// heights: m, no NaN. Beyond the border heights are reflected oddly (2 z_edge - z), so that slopes go on.
// Source: progressive morphological filter, Zhang et al. 2003; threshold of Pingel, Clarke & McBride 2013.
// Cost linear in cells, times log(radius) for each radius. Radii grow by a fifth from 6 on.
[[nodiscard]] geometry::Grid<std::uint8_t> object_cells(const geometry::Grid<float>& heights, std::size_t radius,
                                                        double slope);

}  // namespace cairn::segmentation
