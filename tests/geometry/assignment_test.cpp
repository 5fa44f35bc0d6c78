#include "geometry/assignment.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "base/random.hpp"

namespace cairn::geometry {
namespace {

double total(const std::vector<double>& cost, std::size_t columns, const std::vector<std::size_t>& assigned) {
  double sum = 0.0;
  for (std::size_t r = 0; r < assigned.size(); ++r)
    if (assigned[r] != kUnassigned) sum += cost[r * columns + assigned[r]];
  return sum;
}

// Oracle: every permutation of the longer side.
double brute_force(const std::vector<double>& cost, std::size_t rows, std::size_t columns) {
  const std::size_t longer = std::max(rows, columns), shorter = std::min(rows, columns);
  std::vector<std::size_t> order(longer);
  std::iota(order.begin(), order.end(), 0U);
  double best = 1e300;
  do {
    double sum = 0.0;
    for (std::size_t i = 0; i < shorter; ++i)
      sum += rows <= columns ? cost[i * columns + order[i]] : cost[order[i] * columns + i];
    best = std::min(best, sum);
  } while (std::next_permutation(order.begin(), order.end()));
  return best;
}

TEST(Assign, EqualsBruteForce) {
  constexpr double kTol = 1e-9;  // sums of at most 7 numbers of order 1
  base::Random random(1, "assign", 0);
  for (int trial = 0; trial < 200; ++trial) {
    const std::size_t rows = 1 + random.below(6), columns = 1 + random.below(7);
    std::vector<double> cost(rows * columns);
    for (auto& c : cost) c = trial % 2 == 0 ? random.uniform(-1.0, 1.0) : static_cast<double>(random.below(3));
    const auto result = assign(cost, rows, columns);
    ASSERT_EQ(result.size(), rows);
    auto used = result;
    std::erase(used, kUnassigned);
    EXPECT_EQ(used.size(), std::min(rows, columns));
    std::sort(used.begin(), used.end());
    EXPECT_EQ(std::adjacent_find(used.begin(), used.end()), used.end()) << "a column was used twice";
    EXPECT_NEAR(total(cost, columns, result), brute_force(cost, rows, columns), kTol);
  }
}

TEST(Assign, EmptySides) {
  EXPECT_TRUE(assign({}, 0, 3).empty());
  EXPECT_EQ(assign({}, 2, 0), (std::vector<std::size_t>{kUnassigned, kUnassigned}));
}

}  // namespace
}  // namespace cairn::geometry
