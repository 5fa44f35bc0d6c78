// Whether a point lies inside a closed mesh.
#pragma once

#include "geometry/triangle_mesh.hpp"
#include "geometry/vec.hpp"

namespace cairn::geometry {

// Generalised winding number (Jacobson et al. 2013, ACM TOG 32:4): solid angles of the triangles seen from p
// (Van Oosterom & Strackee 1983) over 4 pi. 1 inside an outward mesh, 0 outside, in between for open ones; undefined on
// the surface. Cost linear in triangles.
[[nodiscard]] double winding_number(const TriangleMesh& mesh, const Vec3& p);

}  // namespace cairn::geometry
