#include "geometry/triangle_mesh.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace cairn::geometry {
namespace {

struct Edge {
  std::uint32_t low = 0, high = 0;
  std::uint32_t triangle = 0;
  bool forward = true;  // from low to high
};

std::vector<Edge> sorted_edges(const TriangleMesh& mesh) {
  std::vector<Edge> edges;
  edges.reserve(mesh.triangles.size() * 3);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = mesh.triangles[t][k];
      const std::uint32_t b = mesh.triangles[t][(k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), t, a < b});
    }
  std::sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) {
    return std::pair(x.low, x.high) < std::pair(y.low, y.high) ||
           (x.low == y.low && x.high == y.high && x.triangle < y.triangle);
  });
  return edges;
}

std::uint32_t find_root(std::vector<std::uint32_t>& parent, std::uint32_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

}  // namespace

Box3 TriangleMesh::bounds() const {
  Box3 box;
  for (const auto& v : vertices) box.extend(v);
  return box;
}

Vec3 TriangleMesh::centroid(std::size_t triangle) const {
  const Triangle& t = triangles[triangle];
  return (vertices[t[0]] + vertices[t[1]] + vertices[t[2]]) / 3.0;
}

Vec3 TriangleMesh::area_vector(std::size_t triangle) const {
  const Triangle& t = triangles[triangle];
  const Vec3 u = vertices[t[1]] - vertices[t[0]];
  const Vec3 v = vertices[t[2]] - vertices[t[0]];
  return 0.5 * Vec3(u.y() * v.z() - u.z() * v.y(), u.z() * v.x() - u.x() * v.z(), u.x() * v.y() - u.y() * v.x());
}

MeshTopology topology(const TriangleMesh& mesh) {
  MeshTopology result;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (mesh.area_vector(t).squaredNorm() == 0.0) ++result.degenerate_triangles;

  std::vector<std::uint32_t> parent(mesh.triangles.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto edges = sorted_edges(mesh);
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t j = i;
    std::size_t forward = 0;
    while (j < edges.size() && edges[j].low == edges[i].low && edges[j].high == edges[i].high) {
      if (edges[j].forward) ++forward;
      const auto a = find_root(parent, edges[i].triangle);
      const auto b = find_root(parent, edges[j].triangle);
      parent[std::max(a, b)] = std::min(a, b);
      ++j;
    }
    const std::size_t uses = j - i;
    if (uses == 1) ++result.boundary_edges;
    else if (uses > 2) ++result.non_manifold_edges;
    else if (forward != 1) ++result.inconsistent_edges;
    i = j;
  }
  for (std::uint32_t t = 0; t < parent.size(); ++t)
    if (find_root(parent, t) == t) ++result.components;
  return result;
}

TriangleMesh weld(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> order(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto less = [&](std::uint32_t a, std::uint32_t b) {
    const Vec3& p = mesh.vertices[a];
    const Vec3& q = mesh.vertices[b];
    for (int k = 0; k < 3; ++k)
      if (p[k] != q[k]) return p[k] < q[k];
    return a < b;
  };
  std::sort(order.begin(), order.end(), less);
  // The first of each group of equal vertices, in the mesh's own order, represents it.
  std::vector<std::uint32_t> leader(mesh.vertices.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && mesh.vertices[order[i]] == mesh.vertices[order[i - 1]];
    leader[order[i]] = same ? leader[order[i - 1]] : order[i];
  }
  TriangleMesh welded;
  std::vector<std::uint32_t> index(mesh.vertices.size(), 0);
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    if (leader[v] != v) continue;
    index[v] = static_cast<std::uint32_t>(welded.vertices.size());
    welded.vertices.push_back(mesh.vertices[v]);
    if (!mesh.colours.empty()) welded.colours.push_back(mesh.colours[v]);
  }
  for (const auto& t : mesh.triangles) {
    const Triangle mapped{index[leader[t[0]]], index[leader[t[1]]], index[leader[t[2]]]};
    if (mapped[0] == mapped[1] || mapped[1] == mapped[2] || mapped[2] == mapped[0]) continue;
    welded.triangles.push_back(mapped);
    if (welded.area_vector(welded.triangles.size() - 1).squaredNorm() == 0.0) welded.triangles.pop_back();
  }
  return welded;
}

TriangleMesh flipped(const TriangleMesh& mesh) {
  TriangleMesh result = mesh;
  for (auto& t : result.triangles) std::swap(t[1], t[2]);
  return result;
}

}  // namespace cairn::geometry
