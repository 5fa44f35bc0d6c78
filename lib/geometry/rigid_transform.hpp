// Rigid transforms and similarities, named T_a_b: p_a = T_a_b * p_b.
#pragma once

#include "geometry/vec.hpp"

namespace cairn::geometry {

// Unit quaternion, Hamilton, always named components.
struct Quaternion {
  double qw = 1.0, qx = 0.0, qy = 0.0, qz = 0.0;

  [[nodiscard]] double norm() const;
  friend bool operator==(const Quaternion&, const Quaternion&) = default;
};

// Rotation matrix of q / |q|. Precondition: |q| > 0.
[[nodiscard]] Mat3 rotation_matrix(const Quaternion& q);
// Unit quaternion with qw >= 0 of a rotation matrix.
[[nodiscard]] Quaternion quaternion(const Mat3& rotation);
// Nearest rotation in the Frobenius norm (by SVD); for matrices read from text.
[[nodiscard]] Mat3 nearest_rotation(const Mat3& matrix);
// Rotation angle of R [rad, 0..pi]: acos((tr R - 1)/2), stable near 0 and pi.
[[nodiscard]] double rotation_angle(const Mat3& rotation);
// Rotation by `angle` [rad] about a unit axis (Rodrigues).
[[nodiscard]] Mat3 axis_rotation(const Vec3& axis, double angle);

// p_a = rotation * p_b + translation.
struct RigidTransform {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();  // origin of b in a, m

  [[nodiscard]] Vec3 operator*(const Vec3& p_b) const { return rotation * p_b + translation; }
  [[nodiscard]] RigidTransform operator*(const RigidTransform& T_b_c) const {
    return {rotation * T_b_c.rotation, rotation * T_b_c.translation + translation};
  }
  [[nodiscard]] RigidTransform inverse() const { return {rotation.transpose(), -(rotation.transpose() * translation)}; }
};

// p_a = scale * rotation * p_b + translation, scale > 0.
struct Similarity {
  double scale = 1.0;
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();

  [[nodiscard]] Vec3 operator*(const Vec3& p_b) const { return scale * (rotation * p_b) + translation; }
  [[nodiscard]] Similarity inverse() const {
    return {1.0 / scale, rotation.transpose(), -(rotation.transpose() * translation) / scale};
  }
};

}  // namespace cairn::geometry
