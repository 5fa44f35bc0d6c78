// Filling cells without data.
#pragma once

#include <cstdint>

#include "geometry/grid.hpp"

namespace cairn::segmentation {

// Fills every NaN cell: averages over ever larger squares come down again by bilinear interpolation (push-pull, Gortler
// et al. 1996), then `rounds` of relaxation towards the mean of the four neighbours smooth what was filled. Known cells
// keep their bits. Unchanged where no cell is known. Cost linear.
void fill_all(geometry::Grid<float>& grid, int rounds = 16);

// Cells that a closing of `mask` by a square of (2 reach + 1) cells holds: holes and bays up to 2 reach cells wide are
// filled in, the outer border does not grow. Cost linear.
[[nodiscard]] geometry::Grid<std::uint8_t> closed_mask(const geometry::Grid<std::uint8_t>& mask, std::size_t reach);

// Morphological opening of heights (no NaN) by a square of (2 radius + 1) cells: what is narrower is cut off. The
// window ends at the grid's border. Van Herk 1992, Gil & Werman 1993: cost linear, whatever the radius.
[[nodiscard]] geometry::Grid<float> opened(const geometry::Grid<float>& heights, std::size_t radius);

// Index in `values` of the cell that holds p, of the nearest one where it lies beside the grid.
[[nodiscard]] std::size_t clamped_cell(const geometry::GridGeometry& g, const geometry::Vec2& p);

}  // namespace cairn::segmentation
