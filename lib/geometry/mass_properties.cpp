#include "geometry/mass_properties.hpp"

namespace cairn::geometry {

MassProperties mass_properties(const TriangleMesh& mesh) {
  MassProperties result;
  if (mesh.triangles.empty()) return result;
  const Vec3 reference = mesh.bounds().centre();

  double six_volume = 0.0;
  Vec3 moment = Vec3::Zero();
  Mat3 second = Mat3::Zero();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle& t = mesh.triangles[i];
    const Vec3 a = mesh.vertices[t[0]] - reference;
    const Vec3 b = mesh.vertices[t[1]] - reference;
    const Vec3 c = mesh.vertices[t[2]] - reference;
    const Vec3 s = a + b + c;
    const double det = a.x() * (b.y() * c.z() - b.z() * c.y()) - a.y() * (b.x() * c.z() - b.z() * c.x()) +
                       a.z() * (b.x() * c.y() - b.y() * c.x());
    six_volume += det;
    moment += det * s;
    second += det * (a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose());
    result.area += mesh.area_vector(i).norm();
  }
  result.volume = six_volume / 6.0;
  if (result.volume == 0.0) {
    result.centre_of_mass = reference;
    return result;
  }
  const Vec3 com = moment / (24.0 * result.volume);
  const Mat3 covariance = second / 120.0 - result.volume * com * com.transpose();
  result.centre_of_mass = com + reference;
  result.inertia_per_density = covariance.trace() * Mat3::Identity() - covariance;
  return result;
}

}  // namespace cairn::geometry
