#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>

#include "surface/mesh_checks.hpp"

namespace cairn::surface {

geometry::TriangleMesh convex_hull(std::span<const geometry::Vec3> points) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
  geometry::TriangleMesh result;
  if (points.size() < 4) return result;
  const geometry::Vec3 origin = points.front();
  std::vector<Kernel::Point_3> local;
  local.reserve(points.size());
  for (const auto& p : points) {
    const geometry::Vec3 q = p - origin;
    local.emplace_back(q.x(), q.y(), q.z());
  }
  Mesh hull;
  CGAL::convex_hull_3(local.begin(), local.end(), hull);
  if (!CGAL::is_closed(hull)) return result;
  for (const auto v : hull.vertices()) {
    const auto& p = hull.point(v);
    result.vertices.emplace_back(geometry::Vec3(p.x(), p.y(), p.z()) + origin);
  }
  for (const auto f : hull.faces()) {
    geometry::Triangle t{};
    std::size_t k = 0;
    for (const auto v : CGAL::vertices_around_face(hull.halfedge(f), hull)) t.at(k++) = static_cast<std::uint32_t>(v);
    result.triangles.push_back(t);
  }
  return result;
}

}  // namespace cairn::surface
