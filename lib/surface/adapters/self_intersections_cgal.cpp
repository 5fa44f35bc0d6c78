#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>

#include "surface/mesh_checks.hpp"

namespace cairn::surface {

bool self_intersects(const geometry::TriangleMesh& mesh) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
  if (mesh.triangles.empty()) return false;
  const geometry::Vec3 origin = mesh.vertices[mesh.triangles.front()[0]];
  Mesh copy;
  for (const auto& p : mesh.vertices) {
    const geometry::Vec3 q = p - origin;
    copy.add_vertex(Kernel::Point_3(q.x(), q.y(), q.z()));
  }
  for (const auto& t : mesh.triangles)
    if (copy.add_face(Mesh::Vertex_index(t[0]), Mesh::Vertex_index(t[1]), Mesh::Vertex_index(t[2])) ==
        Mesh::null_face())
      return true;
  return CGAL::Polygon_mesh_processing::does_self_intersect(copy);
}

}  // namespace cairn::surface
