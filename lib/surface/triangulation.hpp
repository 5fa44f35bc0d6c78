// Points seen from above, joined to triangles.
#pragma once

#include <span>
#include <vector>

#include "geometry/triangle_mesh.hpp"
#include "geometry/vec.hpp"

namespace cairn::surface {

// Delaunay triangulation in plan, counter-clockwise from above, sorted so that the result does not
// depend on the library's traversal. Indices are into `points`. Points with the plan position
// of an earlier one take no part. Fewer than 3 points, or all on a line: empty. Cost n log n.
[[nodiscard]] std::vector<geometry::Triangle> delaunay(std::span<const geometry::Vec2> points);

// Removes triangles from the rim while their outer edge is longer than max_edge [m] and the rest stays
// one piece bounded by one simple ring (characteristic shape, Duckham et al. 2008, Pattern Recognition 41:3224;
// there every point stays in, as here). `triangles` is a Delaunay triangulation. Longest edges first,
// ties by index. Cost n log n.
[[nodiscard]] std::vector<geometry::Triangle> trim_rim(std::span<const geometry::Vec2> points,
                                                       std::vector<geometry::Triangle> triangles, double max_edge);

}  // namespace cairn::surface
