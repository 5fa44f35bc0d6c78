#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>

#include "surface/triangulation.hpp"

namespace cairn::surface {

std::vector<geometry::Triangle> delaunay(std::span<const geometry::Vec2> points) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using Vertex = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, Kernel>;
  using Structure = CGAL::Triangulation_data_structure_2<Vertex>;
  using Delaunay = CGAL::Delaunay_triangulation_2<Kernel, Structure>;

  Delaunay triangulation;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const std::size_t before = triangulation.number_of_vertices();
    const auto vertex = triangulation.insert(Kernel::Point_2(points[i].x(), points[i].y()));
    if (triangulation.number_of_vertices() > before) vertex->info() = i;
  }
  std::vector<geometry::Triangle> triangles;
  for (auto face = triangulation.finite_faces_begin(); face != triangulation.finite_faces_end(); ++face) {
    geometry::Triangle t{face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()};
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    triangles.push_back(t);
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

}  // namespace cairn::surface
