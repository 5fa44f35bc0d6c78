// A rock that rests on one point: it has no tipping angle, but it may still be stable against rolling.
#pragma once

#include <optional>

#include "geometry/mass_properties.hpp"
#include "geometry/triangle_mesh.hpp"
#include "survey/rock.hpp"

namespace cairn::fragility {

// Stable iff 1/H > k_rock + k_pedestal for the greatest curvature of the rock at the point (fragility.md section 6.1;
// both convex > 0; a hollow pedestal has k < 0). The rock's curvature comes from a least-squares quadric through the
// mesh's vertices within `reach` of the point (plan distance, m; 0 = a tenth of the height of the centre of mass).
// Empty where the surface has fewer than 9 vertices there, or the point is not below the centre of mass.
// Precondition: normal at the point near the vertical. Cost linear in vertices.
[[nodiscard]] std::optional<survey::RollingContact> rolling_rule(const geometry::TriangleMesh& mesh,
                                                                 const geometry::MassProperties& mass,
                                                                 const geometry::Vec3& contact,
                                                                 double pedestal_curvature = 0.0, double reach = 0.0);

}  // namespace cairn::fragility
