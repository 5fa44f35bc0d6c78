// Inside and outside of points with normals, over a lattice.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "geometry/vec.hpp"
#include "surface/lattice.hpp"

namespace cairn::surface {

// Nodes for a lattice that `solve_poisson` can coarsen: count = a multiple of 2^levels, plus one.
[[nodiscard]] std::int64_t poisson_count(double extent, double step);

// Indicator function, about 1 inside and 0 outside: the least-squares solution of grad f = -(surface normals)
// (Kazhdan et al. 2006, SGP), trilinear elements on the lattice, 0 on its boundary, by multigrid. What the points
// leave open is bridged as the surface of half the winding number would. areas: of the surface a point stands for
// [m^2]. Cost linear in nodes, about 0.3 us each.
[[nodiscard]] std::vector<float> solve_poisson(const Lattice& lattice, std::span<const geometry::Vec3> points,
                                               std::span<const geometry::Vec3> normals, std::span<const double> areas);

// Value at a position inside the lattice (clamped to it), trilinear.
[[nodiscard]] double interpolate(const Lattice& lattice, std::span<const float> values, const geometry::Vec3& position);

}  // namespace cairn::surface
