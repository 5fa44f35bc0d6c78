// What CGAL can tell about a mesh.
#pragma once

#include <span>

#include "geometry/triangle_mesh.hpp"
#include "geometry/vec.hpp"

namespace cairn::surface {

// Convex hull as a closed outward mesh; empty where the points lie in one plane. Cost n log n. Vertices in order of
// their coordinates, flat sides as fans: the same points give the same mesh.
[[nodiscard]] geometry::TriangleMesh convex_hull(std::span<const geometry::Vec3> points);

// Whether any two triangles meet other than in shared vertices and edges (CGAL's box-intersection test,
// exact predicates). Degenerate triangles and vertices or edges where sheets touch count as intersecting.
// Cost about n log n.
[[nodiscard]] bool self_intersects(const geometry::TriangleMesh& mesh);

}  // namespace cairn::surface
