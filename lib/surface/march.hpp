// Level set of values on a lattice as a closed mesh.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "geometry/triangle_mesh.hpp"
#include "surface/lattice.hpp"

namespace cairn::surface {

// Where the surface crosses the edge from an inner to an outer node: share of the way from the inner, 0..1.
using Crossing = std::function<double(std::size_t inner, std::size_t outer)>;

// Surface between nodes below zero (inside) and the others, by marching tetrahedra (six to a cube, Freudenthal's
// cut). Closed, outward and free of self-intersections whatever the values are, as long as the lattice's boundary
// nodes are outside: each tetrahedron holds at most a triangle or a quadrangle with its corners on its own edges.
// Crossings are kept 2 % of the edge away from the nodes so that no facet vanishes. Cost linear in nodes.
[[nodiscard]] geometry::TriangleMesh march_tetrahedra(const Lattice& lattice, std::span<const float> values,
                                                      const Crossing& crossing);

// The piece of largest volume; `dropped`: number of others.
[[nodiscard]] geometry::TriangleMesh largest_piece(const geometry::TriangleMesh& mesh, std::size_t& dropped);

}  // namespace cairn::surface
