// Edges of facets, sorted so that those of neighbours stand side by side.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/triangle_mesh.hpp"

namespace cairn::coverage {

struct FacetEdge {
  std::uint32_t low = 0, high = 0;  // vertex indices, low < high
  std::uint32_t facet = 0;
  bool forward = true;  // whether the facet runs from low to high

  [[nodiscard]] bool same_edge(const FacetEdge& other) const { return low == other.low && high == other.high; }
};

// Ascending by edge, then facet.
[[nodiscard]] inline std::vector<FacetEdge> facet_edges(const geometry::TriangleMesh& mesh,
                                                        std::span<const std::uint32_t> facets) {
  std::vector<FacetEdge> edges;
  edges.reserve(3 * facets.size());
  for (const std::uint32_t f : facets) {
    const geometry::Triangle& t = mesh.triangles[f];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), f, a < b});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const FacetEdge& a, const FacetEdge& b) {
    return a.low != b.low ? a.low < b.low : a.high != b.high ? a.high < b.high : a.facet < b.facet;
  });
  return edges;
}

}  // namespace cairn::coverage
