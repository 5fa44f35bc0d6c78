// A closed surface through noisy points seen from all sides, with caps where nothing can be seen.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/vec.hpp"
#include "surface/cap_patch.hpp"
#include "surface/top_surface.hpp"

namespace cairn::surface {

struct ImplicitSettings {
  double step_factor = 1.6;            // edge of the lattice's cells in point spacings
  double reach_factor = 2.4;           // reach of the local fits in cells
  std::size_t max_nodes = 24'000'000;  // coarser cells from there on
};

struct ImplicitSurface {
  FlaggedMesh surface;           // closed, outward, one piece, free of self-intersections; empty where there is none
  double spacing = 0.0;          // m: square root of the area a point stands for, median
  double noise = 0.0;            // m: standard deviation (robust) of the points about the surface
  double step = 0.0;             // m: edge of the cells
  std::size_t stray_points = 0;  // in clusters apart from the rock, or on no surface: not used
  std::size_t pieces_dropped = 0;
};

// Where the points are dense: algebraic point set surface; elsewhere a Poisson indicator over twice the step; the cap
// where one is given. Smoothing radius: reach_factor x step_factor spacings, more where the noise asks for it.
// Details smaller than that are rounded. The order of the points does not matter.
// Cost linear in points and in nodes: about 10 us a point.
[[nodiscard]] ImplicitSurface implicit_surface(std::span<const geometry::Vec3> points, std::span<const CapPatch> caps,
                                               double spacing, const ImplicitSettings& settings);

// Square root of the area a point stands for, from its eight nearest: the 70th percentile over a sample of the points
// [m]. 0 for fewer than 9 distinct points.
[[nodiscard]] double surface_spacing(std::span<const geometry::Vec3> points);

}  // namespace cairn::surface
