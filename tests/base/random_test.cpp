#include "base/random.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace cairn::base {
namespace {

TEST(Random, KeyedByAllThree) {
  const auto first = [](std::uint64_t seed, const char* stage, std::uint64_t id) {
    return Random(seed, stage, id).bits();
  };
  const auto reference = first(1, "locate", 5);
  EXPECT_EQ(first(1, "locate", 5), reference);
  EXPECT_NE(first(2, "locate", 5), reference);
  EXPECT_NE(first(1, "segment", 5), reference);
  EXPECT_NE(first(1, "locate", 6), reference);
}

TEST(Random, MomentsOfUniformAndNormal) {
  constexpr int kDraws = 400000;
  // Four standard errors of the mean at this number of draws.
  constexpr double kMeanTol = 4.0 / 632.0;
  Random random(7, "moments", 0);
  double uniform = 0.0, normal = 0.0, square = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double u = random.uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    uniform += u;
    const double n = random.normal();
    normal += n;
    square += n * n;
  }
  EXPECT_NEAR(uniform / kDraws, 0.5, kMeanTol * 0.2887);
  EXPECT_NEAR(normal / kDraws, 0.0, kMeanTol);
  EXPECT_NEAR(square / kDraws, 1.0, kMeanTol * std::sqrt(2.0));
}

TEST(Random, BelowCoversItsRangeEvenly) {
  constexpr int kDraws = 70000;
  Random random(9, "below", 0);
  int counts[7] = {};
  for (int i = 0; i < kDraws; ++i) ++counts[random.below(7)];
  // Five standard deviations of a binomial count.
  for (const int c : counts) EXPECT_NEAR(c, kDraws / 7, 5.0 * std::sqrt(kDraws / 7.0));
}

// The stream is part of the contract: results on disk depend on it.
TEST(Random, StreamIsFixed) {
  Random random(0, "stage", 0);
  const auto a = random.bits();
  const auto b = random.bits();
  EXPECT_EQ(Random(0, "stage", 0).bits(), a);
  EXPECT_NE(a, b);
  EXPECT_EQ(stable_hash("locate"), 0xe09260e003a7fd3fULL);
}

}  // namespace
}  // namespace cairn::base
