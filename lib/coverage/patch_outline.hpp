// Outline of a patch of facets, seen from above.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/primitives.hpp"
#include "geometry/triangle_mesh.hpp"

namespace cairn::coverage {

// Rings around the facets, from above: outer ones counter-clockwise, holes clockwise, the largest first. Vertices on
// a straight run are dropped. Empty where the patch has no area from above (then ask for the convex hull).
// Where rings touch in a vertex they stay apart. Facets must be connected and turned upwards.
// Cost n log n.
[[nodiscard]] std::vector<geometry::Ring> patch_outline(const geometry::TriangleMesh& mesh,
                                                        std::span<const std::uint32_t> facets);

}  // namespace cairn::coverage
