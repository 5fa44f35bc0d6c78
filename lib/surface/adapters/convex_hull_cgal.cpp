#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>

#include <algorithm>
#include <map>

#include "surface/mesh_checks.hpp"

namespace cairn::surface {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Mesh = CGAL::Surface_mesh<Point>;
using Loop = std::vector<std::uint32_t>;

// Boundary of the coplanar faces around `seed`, counter-clockwise from outside, without the vertices
// that lie on a straight line between their neighbours.
Loop facet_loop(const Mesh& hull, Mesh::Face_index seed, const std::vector<std::uint32_t>& rank,
                std::vector<bool>& taken) {
  std::map<Mesh::Vertex_index, Mesh::Vertex_index> next;
  std::vector<Mesh::Face_index> queue{seed};
  taken[seed] = true;
  const auto corner = [&](Mesh::Halfedge_index h) -> const Point& { return hull.point(hull.target(hull.next(h))); };
  for (std::size_t i = 0; i < queue.size(); ++i) {
    for (const auto h : CGAL::halfedges_around_face(hull.halfedge(queue[i]), hull)) {
      const auto across = hull.opposite(h);
      const bool coplanar =
          CGAL::coplanar(hull.point(hull.source(h)), hull.point(hull.target(h)), corner(h), corner(across));
      if (!coplanar) {
        next[hull.source(h)] = hull.target(h);
      } else if (const auto neighbour = hull.face(across); !taken[neighbour]) {
        taken[neighbour] = true;
        queue.push_back(neighbour);
      }
    }
  }
  std::vector<Mesh::Vertex_index> around{next.begin()->first};
  for (auto v = next.at(around[0]); v != around[0]; v = next.at(v)) around.push_back(v);
  Loop loop;
  for (std::size_t i = 0; i < around.size(); ++i) {
    const auto before = around[(i + around.size() - 1) % around.size()], after = around[(i + 1) % around.size()];
    if (!CGAL::collinear(hull.point(before), hull.point(around[i]), hull.point(after))) loop.push_back(rank[around[i]]);
  }
  std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
  return loop;
}

}  // namespace

geometry::TriangleMesh convex_hull(std::span<const geometry::Vec3> points) {
  geometry::TriangleMesh result;
  if (points.size() < 4) return result;
  const geometry::Vec3 origin = points.front();
  std::vector<Point> local;
  local.reserve(points.size());
  for (const auto& p : points) {
    const geometry::Vec3 q = p - origin;
    local.emplace_back(q.x(), q.y(), q.z());
  }
  Mesh hull;
  CGAL::convex_hull_3(local.begin(), local.end(), hull);
  if (!CGAL::is_closed(hull)) return result;

  // CGAL walks containers ordered by address, so the order of faces, and how a flat side is cut into
  // triangles, differ from run to run. Vertices are sorted by coordinates and flat sides cut as fans.
  std::vector<Mesh::Vertex_index> order(hull.vertices().begin(), hull.vertices().end());
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return hull.point(a) < hull.point(b); });
  std::vector<std::uint32_t> rank(order.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) rank[order[i]] = i;
  std::vector<Loop> loops;
  std::vector<bool> taken(hull.number_of_faces(), false);
  for (const auto face : hull.faces())
    if (!taken[face]) loops.push_back(facet_loop(hull, face, rank, taken));
  std::sort(loops.begin(), loops.end());

  constexpr auto kUnused = static_cast<std::uint32_t>(-1);
  std::vector<std::uint32_t> index(order.size(), kUnused);
  for (const auto& loop : loops)
    for (const auto v : loop) index[v] = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (index[i] == kUnused) continue;
    index[i] = static_cast<std::uint32_t>(result.vertices.size());
    const Point& p = hull.point(order[i]);
    result.vertices.emplace_back(geometry::Vec3(p.x(), p.y(), p.z()) + origin);
  }
  for (const auto& loop : loops)
    for (std::size_t k = 1; k + 1 < loop.size(); ++k)
      result.triangles.push_back({index[loop[0]], index[loop[k]], index[loop[k + 1]]});
  return result;
}

}  // namespace cairn::surface
