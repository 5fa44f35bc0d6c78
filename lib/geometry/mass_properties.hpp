// Volume, centre of mass and inertia of a closed mesh of uniform density.
#pragma once

#include "geometry/triangle_mesh.hpp"
#include "geometry/vec.hpp"

namespace cairn::geometry {

// All for unit density (1 kg/m^3): multiply mass and inertia by the density.
struct MassProperties {
  double volume = 0.0;                 // m^3, > 0 for an outward mesh, < 0 for an inward one
  Vec3 centre_of_mass = Vec3::Zero();  // m, in the mesh's frame
  // Inertia tensor about the centre of mass / density [m^5]; off-diagonals are -Int xy dV.
  Mat3 inertia_per_density = Mat3::Zero();
  double area = 0.0;  // m^2
};

// Signed tetrahedra from a reference inside the mesh's box, so that the offset of a
// projected CRS costs no digits. Source: sum formulas of M. Kallay / S. Melax as restated in
// docs/science/mass_properties.md. Cost linear in triangles.
// An open mesh gives a number too: ask topology(mesh).closed() first.
[[nodiscard]] MassProperties mass_properties(const TriangleMesh& mesh);

}  // namespace cairn::geometry
