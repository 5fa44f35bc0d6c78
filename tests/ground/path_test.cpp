#include "ground/path.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.hpp"
#include "ground/costmap.hpp"
#include "ground/distance.hpp"

namespace cairn::ground {
namespace {

using geometry::Grid;
using geometry::Vec2;

constexpr double kTol = 1e-9;  // m; sums of a few hundred lengths

TEST(Path, WeighsALineByTheCellsItCrosses) {
  Grid<std::uint8_t> cost({0.0, 2.0, 1.0, 3, 2}, 0);
  cost.at(1, 1) = 126;  // factor 1 + 2 * 126 / 252 = 2
  const std::vector<Vec2> line{{0.5, 0.25}, {2.5, 0.75}};
  const double length = std::hypot(2.0, 0.5);
  EXPECT_NEAR(length_m(line), length, kTol);
  EXPECT_NEAR(weighted_length_m(cost, line, {2.0, false}), length * 1.5, kTol);  // half of it lies in the middle cell
}

TEST(Path, ClearanceIsThatOfBruteForce) {
  base::Random random(4, "clearance", 0);
  for (int trial = 0; trial < 100; ++trial) {
    Grid<std::uint8_t> cost({3.0, 7.0, 0.25, 1 + random.below(50), 1 + random.below(50)}, 0);
    for (auto& value : cost.values) value = random.uniform() < 0.01 ? kLethal : 0;
    const auto& g = cost.geometry;
    std::vector<Vec2> path;  // along a row, so that the cells crossed are plain to see
    const std::size_t row = random.below(g.rows);
    path = {g.centre(row, 0), g.centre(row, g.columns - 1)};
    double expected = 5.0;
    for (std::size_t c = 0; c < g.columns; ++c)
      for (std::size_t i = 0; i < cost.values.size(); ++i)
        if (cost.values[i] == kLethal)
          expected = std::min(expected, (g.centre(i / g.columns, i % g.columns) - g.centre(row, c)).norm());
    EXPECT_NEAR(clearance_m(cost, path, 5.0), expected, kTol);
  }
}

TEST(Smoothed, StraightensStepsOverFreeGround) {
  const Grid<std::uint8_t> cost({0.0, 50.0, 1.0, 50, 50}, 0);
  base::RunContext ctx;
  const auto route = find_route(cost, {40, 3}, {10, 45}, {5.0, false}, ctx);
  const auto straight = smoothed(cost, route.path, {5.0, false});
  ASSERT_EQ(straight.size(), 2U);
  EXPECT_NEAR(length_m(straight), std::hypot(30.0, 42.0), kTol);
}

TEST(Smoothed, IsNoLongerNoCostlierAndNoNearer) {
  base::Random random(5, "smooth", 0);
  base::RunContext ctx;
  int shorter = 0, found = 0;
  for (int trial = 0; trial < 60; ++trial) {
    OccupancyGrid occupancy(geometry::GridGeometry{0.0, 8.0, 0.1, 100, 80}, Occupancy::free);
    for (int i = 0; i < 12; ++i) {
      const std::size_t r = random.below(75), c = random.below(95);
      for (std::size_t k = 0; k < 25; ++k) occupancy.at(r + k / 5, c + k % 5) = Occupancy::occupied;
    }
    const auto cost = costmap(occupancy, {0.2, 3.0, 0.1});
    Grid<std::uint8_t> lethal(cost.geometry, 0);
    for (std::size_t i = 0; i < cost.values.size(); ++i) lethal.values[i] = cost.values[i] == kLethal ? 1 : 0;
    const auto squared = squared_distance(lethal, 250);
    const RouteOptions options{trial % 3 == 0 ? 0.0 : 5.0, false};
    const auto route =
        find_route(cost, {random.below(80), random.below(20)}, {random.below(80), 80 + random.below(20)}, options, ctx);
    if (!route.found) continue;
    ++found;
    const auto smooth = smoothed(cost, route.path, options, &squared);
    EXPECT_EQ(smooth.front(), route.path.front());
    EXPECT_EQ(smooth.back(), route.path.back());
    EXPECT_LE(length_m(smooth), route.length_m + kTol);
    EXPECT_LE(weighted_length_m(cost, smooth, options), weighted_length_m(cost, route.path, options) + 1e-6);
    EXPECT_GE(clearance_m(cost, smooth, 25.0), clearance_m(cost, route.path, 25.0) - kTol);
    // Never over a blocked cell: dense points are all drivable.
    for (const auto& p : with_points(smooth, 0.01)) {
      const auto cell = cost.geometry.cell_at(p);
      ASSERT_TRUE(cell);
      EXPECT_LT(cost.at(cell->first, cell->second), kInscribed);
    }
    if (length_m(smooth) < route.length_m - 0.1) ++shorter;
  }
  EXPECT_GT(found, 30);
  EXPECT_GT(shorter, found / 2);
}

TEST(WithPoints, LeavesNoGapAndKeepsTheCorners) {
  const auto dense = with_points({{0.0, 0.0}, {1.0, 0.0}, {1.0, 0.35}}, 0.25);
  ASSERT_EQ(dense.size(), 7U);
  EXPECT_EQ(dense[4], Vec2(1.0, 0.0));
  for (std::size_t i = 1; i < dense.size(); ++i) EXPECT_LE((dense[i] - dense[i - 1]).norm(), 0.25 + kTol);
}

}  // namespace
}  // namespace cairn::ground
