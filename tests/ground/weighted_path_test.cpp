#include "ground/weighted_path.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.hpp"
#include "ground/dijkstra.hpp"

namespace cairn::ground {
namespace {

using geometry::Grid;

constexpr double kLengthTol = 1e-9;  // of the sum; roundings of a few hundred steps

TEST(WeightedPath, CostsAsLittleAsDijkstrasOnRandomCosts) {
  base::Random random(2, "weighted", 0);
  base::RunContext ctx;
  int found = 0;
  for (int trial = 0; trial < 200; ++trial) {
    Grid<std::uint8_t> cost({0.0, 0.0, 1.0, 1 + random.below(60), 1 + random.below(60)}, 0);
    const double weight = trial % 4 == 0 ? 1000.0 : 0.5 * static_cast<double>(trial % 13);
    // Smooth costs in half of the maps, as an inflated map has; noise in the others.
    const std::uint64_t step = trial % 2 == 0 ? 253 : 6;
    std::uint64_t level = random.below(253);
    for (auto& value : cost.values) {
      level = trial % 2 == 0 ? random.below(253)
                             : std::min<std::uint64_t>(252, level + random.below(step) - (level > 3 ? 3 : 0));
      value = random.uniform() < 0.2 ? kInscribed : static_cast<std::uint8_t>(level);
    }
    const Cell start{random.below(cost.geometry.rows), random.below(cost.geometry.columns)};
    const Cell goal{random.below(cost.geometry.rows), random.below(cost.geometry.columns)};
    cost.at(start.first, start.second) = 7;
    cost.at(goal.first, goal.second) = 9;
    RouteOptions options{weight, false};
    StepFactors factors{};
    for (std::size_t i = 0; i < kInscribed; ++i) factors[i] = step_factor(static_cast<std::uint8_t>(i), options);
    const auto path = weighted_path(cost, factors, start, goal, ctx);
    const double expected = testing::dijkstra(cost, start, goal, weight);
    ASSERT_EQ(!path.cells.empty(), std::isfinite(expected));
    if (path.cells.empty()) continue;
    ++found;
    ASSERT_NEAR(path.weighted, expected, kLengthTol * expected + kLengthTol);
    // The cells walked sum up to what was claimed.
    double sum = 0.0;
    for (std::size_t i = 1; i < path.cells.size(); ++i) {
      const auto [r, c] = path.cells[i];
      const auto [pr, pc] = path.cells[i - 1];
      const auto factor = [&](std::int64_t row, std::int64_t column) {
        return factors[cost.at(static_cast<std::size_t>(row), static_cast<std::size_t>(column))];
      };
      ASSERT_LE(std::max(std::abs(r - pr), std::abs(c - pc)), 1);
      sum +=
          std::hypot(static_cast<double>(r - pr), static_cast<double>(c - pc)) * 0.5 * (factor(r, c) + factor(pr, pc));
    }
    ASSERT_NEAR(sum, path.weighted, kLengthTol * expected + kLengthTol);
  }
  EXPECT_GT(found, 80);
}

}  // namespace
}  // namespace cairn::ground
