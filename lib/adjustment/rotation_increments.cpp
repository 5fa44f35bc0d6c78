#include <Eigen/Geometry>
#include <cmath>

#include "adjustment/bundle_system.hpp"

namespace cairn::adjustment {
namespace {

using geometry::Mat3;
using geometry::Vec3;

constexpr double kSmall = 1e-4;  // rad: below it series to 3rd order are exact to 1e-16

Mat3 cross_matrix(const Vec3& w) {
  Mat3 m;
  m << 0.0, -w.z(), w.y(), w.z(), 0.0, -w.x(), -w.y(), w.x(), 0.0;
  return m;
}

}  // namespace

Mat3 exp_rotation(const Vec3& w) {
  const double angle = w.norm();
  const Mat3 k = cross_matrix(w);
  const double a = angle < kSmall ? 1.0 - angle * angle / 6.0 : std::sin(angle) / angle;
  const double b = angle < kSmall ? 0.5 - angle * angle / 24.0 : (1.0 - std::cos(angle)) / (angle * angle);
  return Mat3::Identity() + a * k + b * k * k;
}

Vec3 log_rotation(const Mat3& rotation) {
  Eigen::Quaterniond q(rotation);
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  if (sine < kSmall) return 2.0 * q.vec() * (1.0 + sine * sine / 6.0);
  return q.vec() * (2.0 * std::atan2(sine, q.w()) / sine);
}

Mat3 right_jacobian(const Vec3& w) {
  const double angle = w.norm();
  const Mat3 k = cross_matrix(w);
  const double a = angle < kSmall ? 0.5 - angle * angle / 24.0 : (1.0 - std::cos(angle)) / (angle * angle);
  const double b =
      angle < kSmall ? 1.0 / 6.0 - angle * angle / 120.0 : (angle - std::sin(angle)) / (angle * angle * angle);
  return Mat3::Identity() - a * k + b * k * k;
}

Mat3 inverse_right_jacobian(const Vec3& w) {
  const double angle = w.norm();
  const Mat3 k = cross_matrix(w);
  const double b = angle < kSmall ? 1.0 / 12.0 + angle * angle / 720.0
                                  : 1.0 / (angle * angle) - 1.0 / (2.0 * angle * std::tan(0.5 * angle));
  return Mat3::Identity() + 0.5 * k + b * k * k;
}

}  // namespace cairn::adjustment
