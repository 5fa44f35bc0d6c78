// Height/width and other ratios of a body, each by a named definition. Screening numbers: no contact is needed.
#pragma once

#include <vector>

#include "geometry/mass_properties.hpp"
#include "geometry/triangle_mesh.hpp"
#include "survey/rock.hpp"

namespace cairn::fragility {

// In this order:
//   hwr_principal    principal axes of the *volume*; height = extent along the axis nearest to the vertical, width =
//   extent
//                    along that one of the other two with the lesser variance (the definition of the PBR statistics
//                    tool, whose average over vertices gives 2.40 and 1.94 for one rock in two meshes)
//                    of axes with equal variance: the lesser side of the least-area rectangle across the height
//   hwr_surface      the same with the principal axes of the *surface area*
//   hwr_upright      vertical extent / lesser side of the least-area rectangle seen from above; up = the true vertical
//   hwr_moments      the same frame without extremes: sides sqrt(12 x second moment of the volume) of the equivalent
//   block length_width     sides of the least-area rectangle seen from above zingg_b_a, zingg_c_b   intermediate / long
//   and short / intermediate side of the equivalent block, principal axes
// Integrals over volume or surface: the density of vertices does not matter. Preconditions: closed outward mesh, its
// mass properties, z true vertical. Cost linear.
[[nodiscard]] std::vector<survey::NamedValue> shape_ratios(const geometry::TriangleMesh& mesh,
                                                           const geometry::MassProperties& mass);

}  // namespace cairn::fragility
