// Facets sorted into small compact tiles, so that a view accepts or refuses many at once and rays run side by side.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/triangle_mesh.hpp"

namespace cairn::coverage {

inline constexpr std::size_t kTileFacets = 128;

struct FacetTile {
  std::size_t begin = 0, end = 0;  // range in FacetTiles::order
  geometry::Vec3 centre = geometry::Vec3::Zero();
  geometry::Vec3 half = geometry::Vec3::Zero();  // half the edges of the box of the centroids
};

struct FacetTiles {
  std::vector<std::uint32_t> order;  // facets with finite centroid and area > 0, neighbours side by side
  std::vector<FacetTile> tiles;      // each of at most kTileFacets
  std::size_t skipped = 0;           // degenerate or non-finite facets, in no tile
};

// Median splits along the longest side (a k-d tree without its nodes). Cost n log n.
[[nodiscard]] FacetTiles sort_into_tiles(const geometry::TriangleMesh& mesh);

}  // namespace cairn::coverage
