// A target's bounding cylinder as facets, named by part, sector and row.
#pragma once

#include <cstddef>
#include <cstdint>

#include "geometry/primitives.hpp"
#include "geometry/triangle_mesh.hpp"

namespace cairn::coverage {

inline constexpr std::size_t kSectors = 72;   // of 5 deg, the first from azimuth 0 to 5 deg clockwise from north
inline constexpr std::size_t kWallRows = 20;  // from the bottom up
inline constexpr std::size_t kTopRings = 6;   // from the axis out

// Facets of one cylinder: first the wall, row by row and sector by sector, two facets each; then the top.
inline constexpr std::size_t kWallFacets = 2 * kSectors * kWallRows;
inline constexpr std::size_t kTopFacets = kSectors * (2 * kTopRings - 1);
inline constexpr std::size_t kCylinderFacets = kWallFacets + kTopFacets;

struct WallPlace {
  std::size_t row = 0, sector = 0;
};
[[nodiscard]] inline WallPlace wall_place(std::size_t facet) {
  return {facet / (2 * kSectors), facet / 2 % kSectors};
}

// Wall and top, outward; no bottom. height and radius > 0. The corners lie on the cylinder, so that facets lie inside
// it by at most 0.1 % of the radius.
[[nodiscard]] geometry::TriangleMesh cylinder_mesh(const geometry::VerticalCylinder& cylinder);

// A point above the circle of `radius` about the axis in the middle of a sector, clockwise from north.
[[nodiscard]] geometry::Vec2 sector_point(const geometry::Vec2& axis, double radius, std::size_t sector);

}  // namespace cairn::coverage
