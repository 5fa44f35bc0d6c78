#include "geometry/rigid_transform.hpp"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>

namespace cairn::geometry {

double Quaternion::norm() const {
  return std::sqrt(qw * qw + qx * qx + qy * qy + qz * qz);
}

Mat3 rotation_matrix(const Quaternion& q) {
  return Eigen::Quaterniond(q.qw, q.qx, q.qy, q.qz).normalized().toRotationMatrix();
}

Quaternion quaternion(const Mat3& rotation) {
  Eigen::Quaterniond q(rotation);
  q.normalize();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  return {q.w(), q.x(), q.y(), q.z()};
}

Mat3 nearest_rotation(const Mat3& matrix) {
  const Eigen::JacobiSVD<Mat3> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 sign = Mat3::Identity();
  sign(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  return svd.matrixU() * sign * svd.matrixV().transpose();
}

double rotation_angle(const Mat3& rotation) {
  const Vec3 axis(rotation(2, 1) - rotation(1, 2), rotation(0, 2) - rotation(2, 0), rotation(1, 0) - rotation(0, 1));
  return std::atan2(axis.norm(), rotation.trace() - 1.0);
}

Mat3 axis_rotation(const Vec3& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

}  // namespace cairn::geometry
