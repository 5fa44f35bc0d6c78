// A watertight shell around points seen from all sides.
#pragma once

#include <span>

#include "geometry/triangle_mesh.hpp"
#include "geometry/vec.hpp"

namespace cairn::surface {

// Alpha wrapping (Portaneri et al. 2022, ACM TOG 41:4; CGAL alpha_wrap_3): closed, 2-manifold, outward.
// alpha [m]: holes smaller than this are bridged, larger ones are entered: the points must leave no gap as
// large, the base included. offset [m]: the shell lies this far outside the points.
// Cost grows with (extent / alpha)^2; about 0.1 ms a vertex. Throws failed_precondition for fewer than 4 points.
[[nodiscard]] geometry::TriangleMesh alpha_wrap(std::span<const geometry::Vec3> points, double alpha, double offset);

}  // namespace cairn::surface
