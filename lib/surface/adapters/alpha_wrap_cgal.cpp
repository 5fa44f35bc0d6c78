#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include "base/error.hpp"
#include "surface/alpha_wrap.hpp"

namespace cairn::surface {

geometry::TriangleMesh alpha_wrap(std::span<const geometry::Vec3> points, double alpha, double offset) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
  if (points.size() < 4)
    throw base::Error(base::ErrorCode::failed_precondition, "wrapping needs at least 4 points")
        .found(std::to_string(points.size()));
  const geometry::Vec3 origin = points.front();
  std::vector<Kernel::Point_3> local;
  local.reserve(points.size());
  for (const auto& p : points) {
    const geometry::Vec3 q = p - origin;
    local.emplace_back(q.x(), q.y(), q.z());
  }
  Mesh wrap;
  CGAL::alpha_wrap_3(local, alpha, offset, wrap);
  geometry::TriangleMesh mesh;
  for (const auto v : wrap.vertices()) {
    const auto& p = wrap.point(v);
    mesh.vertices.emplace_back(geometry::Vec3(p.x(), p.y(), p.z()) + origin);
  }
  for (const auto f : wrap.faces()) {
    geometry::Triangle t{};
    std::size_t k = 0;
    for (const auto v : CGAL::vertices_around_face(wrap.halfedge(f), wrap)) t.at(k++) = static_cast<std::uint32_t>(v);
    mesh.triangles.push_back(t);
  }
  return mesh;
}

}  // namespace cairn::surface
