// Large facets cut into smaller ones, so that one triangle's centroid does not speak for all of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/triangle_mesh.hpp"

namespace cairn::coverage {

struct CutMesh {
  // The vertices given, then the new ones; facets that needed no cut in their order, then the pieces of the others.
  geometry::TriangleMesh mesh;
  std::vector<std::uint32_t> parent;  // of each facet: its index in the mesh given
  std::size_t whole = 0;              // facets not cut; those before this index
  double edge_m = 0.0;                // longest edge left; above the one asked for where the limit was met
};

// Cuts edges longer than max_edge [m] in the middle, again and again, and with them the facets on both sides, so that
// neighbours still share their edges. Degenerate facets and those with a vertex that is not finite or farther than 1e8
// m away are left as they are. Where more than `limit` facets would come of it, the edge is doubled until it fits. The
// pieces do not depend on the order of the facets. Cost: linear in the pieces.
[[nodiscard]] CutMesh cut_large_facets(const geometry::TriangleMesh& mesh, double max_edge, std::size_t limit);

}  // namespace cairn::coverage
