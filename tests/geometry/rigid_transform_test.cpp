#include "geometry/rigid_transform.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <cmath>
#include <numbers>

#include "base/random.hpp"

namespace cairn::geometry {
namespace {

constexpr double kRotationTol = 1e-12;  // rad; a few roundings of numbers of order 1

Mat3 random_rotation(base::Random& random) {
  return rotation_matrix({random.normal(), random.normal(), random.normal(), random.normal()});
}

TEST(RigidTransform, InverseAndComposition) {
  constexpr double kTol_m = 1e-9;  // points within 1 km
  base::Random random(1, "rigid", 0);
  for (int i = 0; i < 100; ++i) {
    const RigidTransform T_a_b{random_rotation(random), {random.uniform(-500, 500), 1.0, -2.0}};
    const RigidTransform T_b_c{random_rotation(random), {0.5, random.uniform(-500, 500), 3.0}};
    const Vec3 p(random.uniform(-100, 100), random.uniform(-100, 100), random.uniform(-100, 100));
    EXPECT_LT((T_a_b.inverse() * (T_a_b * p) - p).norm(), kTol_m);
    EXPECT_LT(((T_a_b * T_b_c) * p - T_a_b * (T_b_c * p)).norm(), kTol_m);
  }
}

TEST(Quaternion, RoundTripsThroughTheMatrix) {
  base::Random random(2, "quaternion", 0);
  for (int i = 0; i < 100; ++i) {
    const Mat3 r = random_rotation(random);
    const Quaternion q = quaternion(r);
    EXPECT_GE(q.qw, 0.0);
    EXPECT_NEAR(q.norm(), 1.0, kRotationTol);
    EXPECT_LT((rotation_matrix(q) - r).norm(), 1e-11);
  }
}

// Hamilton, w first: a quarter turn about z takes x to y.
TEST(Quaternion, IsHamilton) {
  const double h = std::sqrt(0.5);
  EXPECT_LT((rotation_matrix({h, 0, 0, h}) * Vec3::UnitX() - Vec3::UnitY()).norm(), kRotationTol);
}

TEST(RotationAngle, IsStableAtBothEnds) {
  for (const double angle : {0.0, 1e-9, 1e-4, 1.0, std::numbers::pi - 1e-7, std::numbers::pi})
    EXPECT_NEAR(rotation_angle(axis_rotation(Vec3(1, 2, 3).normalized(), angle)), angle, 1e-8);
}

TEST(NearestRotation, RemovesNoiseAndReflection) {
  base::Random random(3, "nearest", 0);
  const Mat3 r = random_rotation(random);
  Mat3 noisy = r;
  for (int i = 0; i < 9; ++i) noisy(i / 3, i % 3) += 1e-6 * random.normal();
  const Mat3 fixed = nearest_rotation(noisy);
  EXPECT_NEAR(fixed.determinant(), 1.0, kRotationTol);
  EXPECT_LT((fixed - r).norm(), 1e-5);
}

TEST(Similarity, InverseUndoes) {
  base::Random random(4, "similarity", 0);
  const Similarity s{0.99936, random_rotation(random), {0.57, -0.01, 0.93}};
  const Vec3 p(30, -40, 5);
  EXPECT_LT((s.inverse() * (s * p) - p).norm(), 1e-12 * 100);
}

}  // namespace
}  // namespace cairn::geometry
