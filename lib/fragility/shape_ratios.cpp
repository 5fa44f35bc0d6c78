#include "fragility/shape_ratios.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "geometry/least_rectangle.hpp"

namespace cairn::fragility {
namespace {

using geometry::Mat3;
using geometry::Vec2;
using geometry::Vec3;

// Second moments of the volume about its centre, per volume: C = tr(I)/2 1 - I.
Mat3 volume_moments(const geometry::MassProperties& mass) {
  return (0.5 * mass.inertia_per_density.trace() * Mat3::Identity() - mass.inertia_per_density) / mass.volume;
}

// Second moments of the surface about its own centroid, per area.
Mat3 surface_moments(const geometry::TriangleMesh& mesh) {
  const Vec3 origin = mesh.vertices.front();
  double area = 0.0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double a = mesh.area_vector(t).norm();
    const auto& tri = mesh.triangles[t];
    const Vec3 p = mesh.vertices[tri[0]] - origin, q = mesh.vertices[tri[1]] - origin,
               r = mesh.vertices[tri[2]] - origin;
    const Vec3 s = p + q + r;
    area += a;
    first += a / 3.0 * s;
    second += a / 12.0 * (p * p.transpose() + q * q.transpose() + r * r.transpose() + s * s.transpose());
  }
  first /= area;
  return second / area - first * first.transpose();
}

double extent(const geometry::TriangleMesh& mesh, const Vec3& axis) {
  const Vec3 origin = mesh.vertices.front();
  double lo = 0.0, hi = 0.0;
  for (const auto& v : mesh.vertices) {
    const double at = axis.dot(v - origin);
    lo = std::min(lo, at);
    hi = std::max(hi, at);
  }
  return hi - lo;
}

double principal_ratio(const geometry::TriangleMesh& mesh, const Mat3& moments) {
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(moments);  // ascending variance
  int height = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(solver.eigenvectors()(2, i)) > std::abs(solver.eigenvectors()(2, height))) height = i;
  const int width = height == 0 ? 1 : 0, other = height == 2 ? 1 : 2;
  const Vec3 up = solver.eigenvectors().col(height);
  const double variance = solver.eigenvalues()(width);
  // Axes of equal variance (a square section) have no direction of their own: the narrowest rectangle has.
  constexpr double kEqual = 1e-6;
  if (solver.eigenvalues()(other) - variance > kEqual * variance)
    return extent(mesh, up) / extent(mesh, solver.eigenvectors().col(width));
  const Vec3 right = solver.eigenvectors().col(width), ahead = solver.eigenvectors().col(other);
  std::vector<Vec2> section;
  section.reserve(mesh.vertices.size());
  for (const auto& v : mesh.vertices) {
    const Vec3 d = v - mesh.vertices.front();
    section.emplace_back(right.dot(d), ahead.dot(d));
  }
  return extent(mesh, up) / geometry::least_area_rectangle(section).width;
}

}  // namespace

std::vector<survey::NamedValue> shape_ratios(const geometry::TriangleMesh& mesh, const geometry::MassProperties& mass) {
  const Mat3 volume = volume_moments(mass);
  std::vector<Vec2> plan;
  plan.reserve(mesh.vertices.size());
  for (const auto& v : mesh.vertices) plan.push_back((v - mesh.vertices.front()).head<2>());
  const auto rectangle = geometry::least_area_rectangle(plan);
  const double height = extent(mesh, Vec3::UnitZ());
  const Eigen::SelfAdjointEigenSolver<geometry::Mat2> level(volume.topLeftCorner<2, 2>());
  const Eigen::SelfAdjointEigenSolver<Mat3> sides(volume);
  const auto ratio = [](double a, double b) { return std::sqrt(a / b); };
  return {{"hwr_principal", principal_ratio(mesh, volume)},
          {"hwr_surface", principal_ratio(mesh, surface_moments(mesh))},
          {"hwr_upright", height / rectangle.width},
          {"hwr_moments", ratio(volume(2, 2), level.eigenvalues()(0))},
          {"length_width", rectangle.length / rectangle.width},
          {"zingg_b_a", ratio(sides.eigenvalues()(1), sides.eigenvalues()(2))},
          {"zingg_c_b", ratio(sides.eigenvalues()(0), sides.eigenvalues()(1))}};
}

}  // namespace cairn::fragility
