// Problems in the format of "Bundle Adjustment in the Large".
#include <gtest/gtest.h>

#include "adjustment/bundle_system.hpp"
#include "support/bal.hpp"
#include "support/data.hpp"

namespace cairn::adjustment {
namespace {

// Three photographs and seven points of the Dubrovnik collection, as gtsam ships them.
TEST(BundleBal, Dubrovnik) {
  auto system = testing::read_bal(testing::test_data("bal/dubrovnik-3-7-pre.txt"));
  EXPECT_EQ(system.poses.size(), 3U);
  EXPECT_EQ(system.observations.size(), 19U);
  base::RunContext ctx;
  const auto round = solve_bundle(system, {200, 1e-10}, ctx);
  EXPECT_TRUE(round.converged) << round.termination;
  EXPECT_GT(round.cost_before, 1000.0);
  EXPECT_LT(round.cost_after, 1e-6);  // 38 equations, 41 unknowns of which 7 are free: it can be met exactly
}

TEST(BundleBal, MadeUpProblemEndsAtItsNoise) {
  auto system = testing::made_up_bal(9, 1500);
  base::RunContext ctx;
  const auto round = solve_bundle(system, {50, 1e-8}, ctx);
  EXPECT_TRUE(round.converged);
  const double unknowns = 9.0 * 9.0 + 3.0 * static_cast<double>(system.points.size()) - 7.0;
  const double expected = 0.5 * 0.25 * (2.0 * static_cast<double>(system.observations.size()) - unknowns);
  EXPECT_NEAR(round.cost_after / expected, 1.0, 0.05);  // 2000 degrees of freedom: 3 % is one sigma
}

TEST(BundleBal, SameBitsTwice) {
  auto a = testing::made_up_bal(5, 300), b = testing::made_up_bal(5, 300);
  base::RunContext ctx;
  const auto first = solve_bundle(a, {50, 1e-8}, ctx), second = solve_bundle(b, {50, 1e-8}, ctx);
  EXPECT_EQ(first.cost_after, second.cost_after);
  EXPECT_EQ(a.poses[3].translation, b.poses[3].translation);
}

}  // namespace
}  // namespace cairn::adjustment
