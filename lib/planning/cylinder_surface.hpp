// A bounding cylinder as facets.
#pragma once

#include <cstddef>

#include "geometry/primitives.hpp"
#include "geometry/triangle_mesh.hpp"

namespace cairn::planning {

struct CylinderSurface {
  geometry::TriangleMesh mesh;  // outward; corners on the cylinder; no bottom
  std::size_t side_facets = 0;  // the first ones; the others are of the top
};

// sectors >= 3, rows and rings >= 1.
[[nodiscard]] CylinderSurface cylinder_surface(const geometry::VerticalCylinder& cylinder, std::size_t sectors,
                                               std::size_t rows, std::size_t rings);

}  // namespace cairn::planning
