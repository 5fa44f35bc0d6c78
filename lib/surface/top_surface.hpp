// A closed body from points seen from above only.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "geometry/triangle_mesh.hpp"
#include "geometry/vec.hpp"

namespace cairn::surface {

// A mesh with a flag a triangle: 1 where points support it, 0 where it was made up (skirt, cap, bridge).
struct FlaggedMesh {
  geometry::TriangleMesh mesh;
  std::vector<std::uint8_t> seen;
};

// Height field over the plan of the points, closed by a vertical skirt down to the ground and a cap that
// lies on the ground. Nothing hangs over in the result: an upper bound of what stands below the seen rim.
//   points  rock points, m, z up; where two share a plan position the higher counts
//   ground  up coordinate of the ground at a plan position
//   max_edge  longest rim edge [m] that is not followed inwards (concave outlines)
//   clearance  least height of the surface above the cap [m], > 0, so that no facet is degenerate
// Empty mesh where fewer than 3 points, or all on one line in plan. Closed and free of self-intersections by
// construction. Cost n log n.
[[nodiscard]] FlaggedMesh close_top_surface(std::span<const geometry::Vec3> points,
                                            const std::function<double(const geometry::Vec2&)>& ground, double max_edge,
                                            double clearance);

}  // namespace cairn::surface
