// The convex body that is fitted to a target's boxes, by its support function.
#pragma once

#include <cmath>
#include <cstddef>

#include "geometry/vec.hpp"

namespace cairn::localisation {

// A body symmetric about its centre c. With A the symmetric positive definite half-axis matrix of its level
// mid-section, w its half height and k the lean of its top (m), a direction n = (n_h, n_z) meets it at
//   h(n) = max over the body of n.(p - c) = (|A n_h|^e + |k.n_h + w n_z|^e)^(1/e).
// e = 2: every ellipsoid, each once (Q = M M^T with M = [[A, k], [0, w]]; h = sqrt(n^T Q n), which is the dual
// quadric). e = 1: upright or leaning cylinders. Between: rounded blocks, as worn rocks are.
// A = exp([[p + q, r], [r, p - q]]), w = exp(t), e = 1 + exp(s): whatever the numbers, the body is proper, and
// nothing is singular where the mid-section is a circle.
inline constexpr std::size_t kBodyParameters = 10;
// Order of the parameters.
enum BodyParameter : std::size_t {
  kCentreEast,     // m, relative to a given origin
  kCentreNorth,    // m
  kCentreUp,       // m
  kLogRadius,      // p: log of the geometric mean of the level semi-axes, m
  kStretchEast,    // q: half the log of their ratio, east against north
  kStretchDiag,    // r: the same between the diagonals
  kLogHalfHeight,  // t, m
  kLeanEast,       // k, m
  kLeanNorth,
  kLogRoundness  // s: 0 = ellipsoid
};

// A symmetric, positive definite.
template <typename T>
Eigen::Matrix<T, 2, 2> half_axis_matrix(const T* x) {
  using std::cosh, std::exp, std::sinh, std::sqrt;
  const T square = x[kStretchEast] * x[kStretchEast] + x[kStretchDiag] * x[kStretchDiag];
  T even(1.0), odd(1.0);  // cosh d and sinh(d)/d, both analytic in d^2
  if (square > T(1e-6)) {
    const T d = sqrt(square);
    even = cosh(d);
    odd = sinh(d) / d;
  } else {
    even = T(1.0) + square * (T(0.5) + square / T(24.0));
    odd = T(1.0) + square * (T(1.0 / 6.0) + square / T(120.0));
  }
  const T scale = exp(x[kLogRadius]);
  Eigen::Matrix<T, 2, 2> a;
  a(0, 0) = scale * (even + odd * x[kStretchEast]);
  a(1, 1) = scale * (even - odd * x[kStretchEast]);
  a(0, 1) = a(1, 0) = scale * odd * x[kStretchDiag];
  return a;
}

// h(n) for any n, not only of unit length: h(s n) = s h(n), s >= 0. [n] m
template <typename T>
T support(const T* x, const geometry::Vec3& n) {
  using std::exp, std::log, std::pow, std::sqrt;
  const Eigen::Matrix<T, 2, 2> a = half_axis_matrix(x);
  const T east = a(0, 0) * n.x() + a(0, 1) * n.y(), north = a(1, 0) * n.x() + a(1, 1) * n.y();
  const T up = x[kLeanEast] * n.x() + x[kLeanNorth] * n.y() + exp(x[kLogHalfHeight]) * n.z();
  const T level2 = east * east + north * north, up2 = up * up;
  // Rounded off by a millionth of the body so that the derivative exists where one part vanishes.
  const T small = T(1e-12) * (level2 + up2);
  const T e = T(1.0) + exp(x[kLogRoundness]), half = T(0.5) * e;
  return pow(pow(level2 + small, half) + pow(up2 + small, half), T(1.0) / e);
}

}  // namespace cairn::localisation
