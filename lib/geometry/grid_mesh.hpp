// A height grid as a triangle mesh.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/grid.hpp"
#include "geometry/triangle_mesh.hpp"

namespace cairn::geometry {

struct GridMesh {
  TriangleMesh mesh;                      // facing up
  std::vector<std::uint32_t> facet_cell;  // cell (row * columns + column) that each facet covers half of
};

// Two triangles for each cell that holds a height; NaN cells are left out. Vertices stand on the cells' corners, at the
// mean of the cells around them, so that a facet belongs to one cell and the surface is continuous (a spike one cell
// wide loses three quarters of its height). The diagonal is the flatter one. heights: m, local up.
// Fewer than 2^31 cells. Cost linear.
[[nodiscard]] GridMesh grid_mesh(const Grid<float>& heights);

}  // namespace cairn::geometry
