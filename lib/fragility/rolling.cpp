#include "fragility/rolling.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

namespace cairn::fragility {

std::optional<survey::RollingContact> rolling_rule(const geometry::TriangleMesh& mesh,
                                                   const geometry::MassProperties& mass, const geometry::Vec3& contact,
                                                   double pedestal_curvature, double reach) {
  using Vec = Eigen::Matrix<double, 6, 1>;
  const double height = mass.centre_of_mass.z() - contact.z();
  if (!(height > 0.0)) return std::nullopt;
  const double radius = reach > 0.0 ? reach : 0.1 * height;
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  Vec right = Vec::Zero();
  int used = 0;
  for (const auto& v : mesh.vertices) {
    const geometry::Vec3 d = (v - contact) / radius;
    // Above the point by more than the reach lies another part of a deeply curved body.
    if (d.head<2>().squaredNorm() > 1.0 || d.z() > 1.0) continue;
    Vec row;
    row << 1.0, d.x(), d.y(), 0.5 * d.x() * d.x(), d.x() * d.y(), 0.5 * d.y() * d.y();
    normal += row * row.transpose();
    right += row * d.z();
    ++used;
  }
  constexpr int kLeast = 9;
  if (used < kLeast) return std::nullopt;
  const Vec fit = normal.ldlt().solve(right);
  if (!fit.allFinite()) return std::nullopt;
  geometry::Mat2 shape;
  shape << fit[3], fit[4], fit[4], fit[5];
  const Eigen::SelfAdjointEigenSolver<geometry::Mat2> solver(shape / radius);
  survey::RollingContact result;
  result.height_m = height;
  result.rock_curvature_1_m = solver.eigenvalues()(1);
  result.pedestal_curvature_1_m = pedestal_curvature;
  result.stable = 1.0 / height > result.rock_curvature_1_m + pedestal_curvature;
  return result;
}

}  // namespace cairn::fragility
