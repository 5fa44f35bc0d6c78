#include "geometry/alignment.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <vector>

#include "base/random.hpp"

namespace cairn::geometry {
namespace {

constexpr double kTol_m = 1e-10;  // rounding over some hundred metres

std::vector<Vec3> some_points(std::size_t count) {
  base::Random random(1, "alignment", 0);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i)
    points.emplace_back(random.uniform(-100, 100), random.uniform(-100, 100), random.uniform(0, 20));
  return points;
}

Similarity some_similarity() {
  return {1.7, axis_rotation(Vec3(1, 2, -1).normalized(), 2.1), Vec3(30, -20, 5)};
}

TEST(AlignPoints, RecoversSimilarity) {
  for (const std::size_t count : {3U, 4U, 20U}) {
    const auto from = some_points(count);
    const auto truth = some_similarity();
    std::vector<Vec3> to;
    for (const auto& p : from) to.push_back(truth * p);
    const auto found = align_points(from, to);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->scale, truth.scale, 1e-12);
    for (std::size_t i = 0; i < count; ++i) EXPECT_LT((*found * from[i] - to[i]).norm(), kTol_m);
    EXPECT_NEAR(found->rotation.determinant(), 1.0, 1e-12);
  }
}

TEST(AlignPoints, KeepsScaleOneOnRequest) {
  const auto from = some_points(10);
  auto truth = some_similarity();
  truth.scale = 1.0;
  std::vector<Vec3> to;
  for (const auto& p : from) to.push_back(truth * p);
  const auto found = align_points(from, to, false);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->scale, 1.0);
  for (std::size_t i = 0; i < from.size(); ++i) EXPECT_LT((*found * from[i] - to[i]).norm(), kTol_m);
}

TEST(AlignPoints, NeverMirrors) {
  const auto from = some_points(10);
  std::vector<Vec3> to;
  for (const auto& p : from) to.emplace_back(-p.x(), p.y(), p.z());
  const auto found = align_points(from, to);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->rotation.determinant(), 1.0, 1e-12);
}

TEST(AlignPoints, WeightZeroLeavesAPointOut) {
  const auto from = some_points(6);
  const auto truth = some_similarity();
  std::vector<Vec3> to;
  for (const auto& p : from) to.push_back(truth * p);
  to[2] += Vec3(50, 0, 0);
  const std::vector<double> weights{1, 1, 0, 1, 2, 1};
  const auto found = align_points(from, to, true, weights);
  ASSERT_TRUE(found);
  EXPECT_LT((*found * from[0] - to[0]).norm(), kTol_m);
}

TEST(AlignPoints, RefusesLinesAndTooFewPoints) {
  const auto two = some_points(2);
  EXPECT_FALSE(align_points(two, two));
  std::vector<Vec3> line;
  for (int i = 0; i < 6; ++i) line.emplace_back(i, 2.0 * i, -i);
  EXPECT_FALSE(align_points(line, line));
  const std::vector<Vec3> one(5, Vec3(1, 2, 3));
  EXPECT_FALSE(align_points(one, one));
}

}  // namespace
}  // namespace cairn::geometry
