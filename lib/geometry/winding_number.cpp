#include "geometry/winding_number.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace cairn::geometry {

double winding_number(const TriangleMesh& mesh, const Vec3& p) {
  double solid_angle = 0.0;
  for (const auto& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]] - p, b = mesh.vertices[t[1]] - p, c = mesh.vertices[t[2]] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    const double denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    solid_angle += 2.0 * std::atan2(a.dot(b.cross(c)), denominator);
  }
  return solid_angle / (4.0 * std::numbers::pi);
}

}  // namespace cairn::geometry
