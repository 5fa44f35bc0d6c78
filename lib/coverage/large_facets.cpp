#include "coverage/large_facets.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace cairn::coverage {
namespace {

using geometry::Triangle;
using geometry::TriangleMesh;
using geometry::Vec3;

constexpr double kFarthest = 1e8;  // m; as visibility::Scene

bool cuttable(const TriangleMesh& mesh, std::size_t facet) {
  const std::size_t count = mesh.vertices.size();
  for (const std::uint32_t v : mesh.triangles[facet])
    if (v >= count || !mesh.vertices[v].allFinite() || mesh.vertices[v].cwiseAbs().maxCoeff() > kFarthest) return false;
  return mesh.area_vector(facet).squaredNorm() > 0.0;
}

double longest_edge(const TriangleMesh& mesh, const Triangle& t) {
  double longest = 0.0;
  for (std::size_t k = 0; k < 3; ++k)
    longest = std::max(longest, (mesh.vertices[t[k]] - mesh.vertices[t[(k + 1) % 3]]).norm());
  return longest;
}

// Facets that halving every long edge would give, from above.
double pieces_of(double longest, double max_edge) {
  double halvings = 0.0;
  for (double edge = longest; edge > max_edge; edge *= 0.5) halvings += 1.0;
  return std::pow(4.0, halvings);
}

double edge_within(const TriangleMesh& mesh, const std::vector<std::uint32_t>& cut, double max_edge,
                   std::size_t limit) {
  for (;; max_edge *= 2.0) {
    double pieces = 0.0;
    for (const std::uint32_t f : cut) pieces += pieces_of(longest_edge(mesh, mesh.triangles[f]), max_edge);
    if (pieces <= static_cast<double>(std::max(limit, cut.size()))) return max_edge;
  }
}

class Cutter {
 public:
  Cutter(TriangleMesh& mesh, double max_edge) : mesh_(mesh), max_edge_(max_edge) {}

  void cut(const Triangle& t, std::vector<Triangle>& pieces) {
    std::vector<Triangle> open{t};
    while (!open.empty()) {
      const Triangle f = open.back();
      open.pop_back();
      const std::array<bool, 3> is_long = {too_long(f[0], f[1]), too_long(f[1], f[2]), too_long(f[2], f[0])};
      const auto count = std::count(is_long.begin(), is_long.end(), true);
      if (count == 0) {
        pieces.push_back(f);
      } else if (count == 3) {
        const std::uint32_t a = middle(f[0], f[1]), b = middle(f[1], f[2]), c = middle(f[2], f[0]);
        open.push_back({c, b, f[2]});
        open.push_back({a, f[1], b});
        open.push_back({f[0], a, c});
        open.push_back({a, b, c});
      } else {
        // One long edge at a time, the longest first: pieces stay compact, and both sides of an edge agree.
        std::size_t k = 0;
        double longest = -1.0;
        for (std::size_t i = 0; i < 3; ++i) {
          const double length = (mesh_.vertices[f[i]] - mesh_.vertices[f[(i + 1) % 3]]).norm();
          if (length > longest) {
            longest = length;
            k = i;
          }
        }
        const std::uint32_t p = f[k], q = f[(k + 1) % 3], r = f[(k + 2) % 3], m = middle(p, q);
        open.push_back({m, q, r});
        open.push_back({p, m, r});
      }
    }
  }

 private:
  [[nodiscard]] bool too_long(std::uint32_t a, std::uint32_t b) const {
    return (mesh_.vertices[a] - mesh_.vertices[b]).norm() > max_edge_;
  }
  std::uint32_t middle(std::uint32_t a, std::uint32_t b) {
    const auto [at, added] = middles_.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh_.vertices.size()));
    if (added) {
      const Vec3 m = 0.5 * (mesh_.vertices[a] + mesh_.vertices[b]);
      mesh_.vertices.push_back(m);
    }
    return at->second;
  }

  TriangleMesh& mesh_;
  double max_edge_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles_;
};

}  // namespace

CutMesh cut_large_facets(const TriangleMesh& mesh, double max_edge, std::size_t limit) {
  CutMesh result;
  std::vector<std::uint32_t> cut;
  result.mesh.vertices = mesh.vertices;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const auto facet = static_cast<std::uint32_t>(f);
    if (cuttable(mesh, f) && longest_edge(mesh, mesh.triangles[f]) > max_edge) {
      cut.push_back(facet);
    } else {
      result.mesh.triangles.push_back(mesh.triangles[f]);
      result.parent.push_back(facet);
    }
  }
  result.edge_m = edge_within(mesh, cut, max_edge, limit);
  result.whole = result.mesh.triangles.size();
  Cutter cutter(result.mesh, result.edge_m);
  std::vector<Triangle> pieces;
  for (const std::uint32_t f : cut) {
    pieces.clear();
    cutter.cut(mesh.triangles[f], pieces);
    result.mesh.triangles.insert(result.mesh.triangles.end(), pieces.begin(), pieces.end());
    result.parent.insert(result.parent.end(), pieces.size(), f);
  }
  return result;
}

}  // namespace cairn::coverage
