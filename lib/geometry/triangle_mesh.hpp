// An indexed triangle mesh in double precision.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/primitives.hpp"
#include "geometry/vec.hpp"

namespace cairn::geometry {

using Triangle = std::array<std::uint32_t, 3>;

// Triangles are counter-clockwise seen from outside. Colours are empty or one per vertex.
struct TriangleMesh {
  std::vector<Vec3> vertices;  // m
  std::vector<Triangle> triangles;
  std::vector<std::array<std::uint8_t, 3>> colours;

  [[nodiscard]] Box3 bounds() const;
  [[nodiscard]] Vec3 centroid(std::size_t triangle) const;
  // Half the cross product of two edges: length = area [m^2], direction = outward normal.
  [[nodiscard]] Vec3 area_vector(std::size_t triangle) const;
};

// What stands between a mesh and a closed, oriented surface.
struct MeshTopology {
  std::size_t boundary_edges = 0;      // used by one triangle
  std::size_t inconsistent_edges = 0;  // used twice in the same direction
  std::size_t non_manifold_edges = 0;  // used more than twice
  std::size_t degenerate_triangles = 0;
  std::size_t components = 0;  // connected by shared edges

  [[nodiscard]] bool closed() const {
    return boundary_edges == 0 && inconsistent_edges == 0 && non_manifold_edges == 0;
  }
};

// Cost n log n in triangles.
[[nodiscard]] MeshTopology topology(const TriangleMesh& mesh);

// Merges vertices with identical coordinates and drops triangles that become degenerate
// (two equal indices or zero area). Order of first appearance is kept.
[[nodiscard]] TriangleMesh weld(const TriangleMesh& mesh);

// The same surface with every triangle turned over.
[[nodiscard]] TriangleMesh flipped(const TriangleMesh& mesh);

}  // namespace cairn::geometry
