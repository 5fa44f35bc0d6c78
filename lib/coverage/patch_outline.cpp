#include "coverage/patch_outline.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "coverage/facet_edges.hpp"

namespace cairn::coverage {
namespace {

using geometry::Ring;
using geometry::Vec2;

struct HalfEdge {
  std::uint32_t from = 0, to = 0;
  friend auto operator<=>(const HalfEdge&, const HalfEdge&) = default;
};

// Edges that bound the patch, in the direction that keeps it on the left.
std::vector<HalfEdge> boundary(const geometry::TriangleMesh& mesh, std::span<const std::uint32_t> facets) {
  std::vector<FacetEdge> edges = facet_edges(mesh, facets);
  std::vector<HalfEdge> result;
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t j = i;
    while (j < edges.size() && edges[j].same_edge(edges[i])) ++j;
    if (j == i + 1) {
      const FacetEdge& e = edges[i];
      result.push_back(e.forward ? HalfEdge{e.low, e.high} : HalfEdge{e.high, e.low});
    }
    i = j;
  }
  std::sort(result.begin(), result.end());
  return result;
}

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Angle [rad] turned to the left, -pi..pi.
double left_turn(const Vec2& before, const Vec2& after) {
  return std::atan2(cross(before, after), before.dot(after));
}

Ring without_straight_vertices(const Ring& ring) {
  constexpr double kStraight = 1e-9;  // of the product of the sides: rounding of the coordinates
  Ring result;
  const std::size_t n = ring.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 a = ring[i] - ring[(i + n - 1) % n], b = ring[(i + 1) % n] - ring[i];
    const bool straight = std::abs(cross(a, b)) <= kStraight * a.norm() * b.norm() && a.dot(b) > 0.0;
    if (!straight && a.squaredNorm() > 0.0) result.push_back(ring[i]);
  }
  return result;
}

}  // namespace

std::vector<Ring> patch_outline(const geometry::TriangleMesh& mesh, std::span<const std::uint32_t> facets) {
  const std::vector<HalfEdge> edges = boundary(mesh, facets);
  std::vector<std::uint8_t> used(edges.size(), 0);
  const auto at = [&mesh](std::uint32_t v) { return Vec2(mesh.vertices[v].head<2>()); };
  std::vector<Ring> rings;
  for (std::size_t start = 0; start < edges.size(); ++start) {
    if (used[start] != 0) continue;
    Ring ring;
    std::size_t e = start;
    bool closed = false;
    while (true) {
      used[e] = 1;
      ring.push_back(at(edges[e].from));
      if (edges[e].to == edges[start].from) {
        closed = true;
        break;
      }
      // Where several edges leave a vertex, the sharpest turn to the left stays with the same facets.
      const Vec2 before = at(edges[e].to) - at(edges[e].from);
      auto next = std::lower_bound(edges.begin(), edges.end(), HalfEdge{edges[e].to, 0});
      std::size_t best = edges.size();
      double turn = -10.0;
      for (; next != edges.end() && next->from == edges[e].to; ++next) {
        const auto k = static_cast<std::size_t>(next - edges.begin());
        if (used[k] != 0) continue;
        const double t = left_turn(before, at(next->to) - at(next->from));
        if (t > turn) {
          turn = t;
          best = k;
        }
      }
      if (best == edges.size()) break;  // facets of mixed orientation: no ring
      e = best;
    }
    ring = without_straight_vertices(ring);
    if (closed && ring.size() >= 3 && geometry::signed_area(ring) != 0.0) rings.push_back(std::move(ring));
  }
  std::stable_sort(rings.begin(), rings.end(),
                   [](const Ring& a, const Ring& b) { return geometry::signed_area(a) > geometry::signed_area(b); });
  return rings;
}

}  // namespace cairn::coverage
