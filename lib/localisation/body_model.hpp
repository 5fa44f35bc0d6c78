// The convex body that is fitted to a target's boxes, by its support function.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "geometry/vec.hpp"

namespace cairn::localisation {

// An ellipsoid with a correction. A = level half-axes (symmetric positive definite), w = half height, k = lean of the
// top against the centre, all in m. With m = M^T n = (A n_h, k.n_h + w n_z) a direction n meets the body at
//   h(n) = max over the body of n.(p - c) = |m| (1 + sum a_lm Y_lm(m / |m|)),   l = 3 .. 6.
// a = 0: every ellipsoid, each once (Q = M M^T; h = sqrt(n^T Q n), which is the dual quadric). l = 1 is the centre and
// l = 0, 2 the ellipsoid; a rock is neither, and the harmonics are how.
// A = exp([[p + q, r], [r, p - q]]), w = exp(t): proper whatever the numbers, smooth where A is a circle.
inline constexpr std::size_t kEllipsoidParameters = 9;
enum EllipsoidParameter : std::size_t {
  kCentreEast,     // m, relative to a given origin
  kCentreNorth,    // m
  kCentreUp,       // m
  kLogRadius,      // p: log of the geometric mean of the level semi-axes [m]
  kStretchEast,    // q: half the log of their ratio, east against north
  kStretchDiag,    // r: the same between the diagonals
  kLogHalfHeight,  // t [m]
  kLeanEast,       // k, m
  kLeanNorth
};

inline constexpr int kLeastDegree = 3, kMostDegree = 6;
inline constexpr std::size_t kHarmonics =
    static_cast<std::size_t>((kMostDegree + 1) * (kMostDegree + 1) - kLeastDegree * kLeastDegree);
// Index of Y_lm, m = -l .. l.
constexpr std::size_t harmonic_index(int l, int m) {
  return static_cast<std::size_t>(l * l + l + m - kLeastDegree * kLeastDegree);
}

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

// M^T n.
template <typename T>
Eigen::Matrix<T, 3, 1> normalised(const T* x, const geometry::Vec3& n) {
  using std::exp;
  const Eigen::Matrix<T, 2, 2> a = half_axis_matrix(x);
  return {a(0, 0) * n.x() + a(0, 1) * n.y(), a(1, 0) * n.x() + a(1, 1) * n.y(),
          x[kLeanEast] * n.x() + x[kLeanNorth] * n.y() + exp(x[kLogHalfHeight]) * n.z()};
}

// Real spherical harmonics of a unit vector, mean square 1 over the sphere, by the recursion of the associated
// Legendre functions divided by sin^m. Negative m: sine of the azimuth from x.
template <typename T>
void harmonics(const Eigen::Matrix<T, 3, 1>& u, std::array<T, kHarmonics>* out) {
  T cosine(1.0), sine(0.0);  // sin^m cos(m phi), sin^m sin(m phi)
  T start(1.0);              // P_mm / sin^m = (2m - 1)!!
  double factorial_ratio = 1.0;
  for (int m = 0; m <= kMostDegree; ++m) {
    if (m > 0) {
      const T next = cosine * u.x() - sine * u.y();
      sine = sine * u.x() + cosine * u.y();
      cosine = next;
      start = start * T(2.0 * m - 1.0);
    }
    T below(0.0), value = start;
    factorial_ratio = 1.0;  // (l - m)! / (l + m)!
    for (int i = 1; i <= 2 * m; ++i) factorial_ratio /= i;
    for (int l = m; l <= kMostDegree; ++l) {
      if (l > m) {
        const T next = (u.z() * T(2.0 * l - 1.0) * value - T(l + m - 1.0) * below) / T(static_cast<double>(l - m));
        below = value;
        value = next;
        factorial_ratio *= static_cast<double>(l - m) / static_cast<double>(l + m);
      }
      if (l < kLeastDegree) continue;
      const T norm = T(std::sqrt((m == 0 ? 1.0 : 2.0) * (2.0 * l + 1.0) * factorial_ratio));
      (*out)[harmonic_index(l, m)] = norm * value * cosine;
      if (m > 0) (*out)[harmonic_index(l, -m)] = norm * value * sine;
    }
  }
}

// h(n) for any n, not only of unit length: h(s n) = s h(n), s >= 0. [n] m
template <typename T>
T ellipsoid_support(const T* x, const geometry::Vec3& n) {
  using std::sqrt;
  const Eigen::Matrix<T, 3, 1> m = normalised(x, n);
  return sqrt(m.x() * m.x() + m.y() * m.y() + m.z() * m.z());
}

struct Body {
  std::array<double, kEllipsoidParameters> ellipsoid{};
  std::array<double, kHarmonics> harmonic{};  // a_lm

  // [n] m
  [[nodiscard]] double support(const geometry::Vec3& n) const;
};

}  // namespace cairn::localisation
