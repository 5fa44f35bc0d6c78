// A patch of cloud thinned to working resolution, with how concave its surface is at each node.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/vec.hpp"

namespace cairn::segmentation {

struct PatchGraph {
  double step = 0.0;                     // edge of the cubes that became nodes, m
  std::vector<geometry::Vec3> position;  // mean of the points of a cube, m
  // How strongly the surface bends inwards, 0 flat .. about 0.2 a narrow cleft; < 0 convex.
  std::vector<float> concavity;
  std::vector<std::uint32_t> node_of;  // one a point

  // Neighbours within two steps, each pair once, a < b.
  struct Pair {
    std::uint32_t a = 0, b = 0;
  };
  std::vector<Pair> pairs;

  [[nodiscard]] std::size_t size() const { return position.size(); }
};

// Cubes of `step` [m]; nodes in order of their cubes. Points finite. n log n.
[[nodiscard]] PatchGraph build_patch_graph(std::span<const geometry::Vec3> points, double step);

// Median distance from a point to its nearest neighbour, from up to 2000 of the points, m; 0 with fewer than 2.
[[nodiscard]] double point_spacing(std::span<const geometry::Vec3> points);

// Sets `concavity`: how far the middle of the neighbours lies off a node, over their reach, along the way from the
// vertical through `axis` and a little upwards; reach: m. What is concave opens that way, and so do the edges of what
// could be seen of a cleft; no normals are asked. Averaged over the near neighbours.
void measure_concavity(PatchGraph& graph, const geometry::Vec2& axis, double reach);

}  // namespace cairn::segmentation
