// Two-dimensional tipping values, as a photograph from one side would give them.
#pragma once

#include <span>
#include <vector>

#include "geometry/triangle_mesh.hpp"
#include "survey/rock.hpp"

namespace cairn::fragility {

// For views towards 0, step, 2 step, .. < 180 deg: the silhouette's area centroid (uniform density, unit thickness) in
// place of the centre of mass, the ends of the contact as seen in place of the edges; alpha_i = atan2(d_i, H_i), each
// rocking point at its own height (fragility.md section 1.1). From a point at infinity. A value of a view bounds
// nothing in three dimensions. mesh closed, z up, m; contact >= 1 point. slices: horizontal cuts through the body;
// exact in each, midpoint rule between. Cost: slices x facets they cut x views.
[[nodiscard]] std::vector<survey::PhotoView> photo_views(const geometry::TriangleMesh& mesh,
                                                         std::span<const geometry::Vec3> contact,
                                                         double step_deg = 15.0, int slices = 96);

}  // namespace cairn::fragility
