#include "geometry/alignment.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

namespace cairn::geometry {

std::optional<Similarity> align_points(std::span<const Vec3> from, std::span<const Vec3> to, bool with_scale,
                                       std::span<const double> weights) {
  const auto weight = [&](std::size_t i) { return weights.empty() ? 1.0 : weights[i]; };
  double total = 0.0;
  std::size_t used = 0;
  Vec3 mean_from = Vec3::Zero(), mean_to = Vec3::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (!(weight(i) > 0.0)) continue;
    total += weight(i);
    ++used;
    mean_from += weight(i) * from[i];
    mean_to += weight(i) * to[i];
  }
  if (used < 3) return std::nullopt;
  mean_from /= total;
  mean_to /= total;
  Mat3 covariance = Mat3::Zero(), spread = Mat3::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Vec3 a = from[i] - mean_from, b = to[i] - mean_to;
    covariance += weight(i) / total * b * a.transpose();
    spread += weight(i) / total * a * a.transpose();
  }
  constexpr double kLine = 1e-6;  // of the variances: 1e-3 of the lengths
  const Vec3 variances = Eigen::JacobiSVD<Mat3>(spread).singularValues();
  if (!(variances[1] > kLine * variances[0])) return std::nullopt;
  const Eigen::JacobiSVD<Mat3> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (!(svd.singularValues()[1] > 0.0)) return std::nullopt;
  Vec3 sign = Vec3::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) sign.z() = -1.0;
  Similarity T;
  T.rotation = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  if (with_scale) T.scale = svd.singularValues().dot(sign) / spread.trace();
  if (!(T.scale > 0.0)) return std::nullopt;
  T.translation = mean_to - T.scale * (T.rotation * mean_from);
  return T;
}

RigidTransform transform_pose(const Similarity& T, const RigidTransform& pose) {
  return {T.rotation * pose.rotation, T * pose.translation};
}

}  // namespace cairn::geometry
