#include "ground/route.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.hpp"
#include "ground/costmap.hpp"
#include "ground/dijkstra.hpp"

namespace cairn::ground {
namespace {

using geometry::Grid;

constexpr double kLengthTol = 1e-9;  // sums of a few hundred step lengths
const RouteOptions kShortest{0.0, false};

Grid<std::uint8_t> map_of(const std::vector<std::string>& rows) {
  Grid<std::uint8_t> cost({0.0, static_cast<double>(rows.size()), 1.0, rows[0].size(), rows.size()}, 0);
  for (std::size_t r = 0; r < rows.size(); ++r)
    for (std::size_t c = 0; c < rows[r].size(); ++c)
      cost.at(r, c) = rows[r][c] == '#' ? kLethal : (rows[r][c] == '?' ? kUnknown : 0);
  return cost;
}

TEST(FindRoute, DoesNotCutCorners) {
  base::RunContext ctx;
  const auto route = find_route(map_of({"...", ".#.", "..."}), {0, 0}, {2, 2}, kShortest, ctx);
  ASSERT_TRUE(route.found);
  EXPECT_NEAR(route.length_m, 4.0, kLengthTol);
  EXPECT_FALSE(find_route(map_of({".#", "#."}), {0, 0}, {1, 1}, kShortest, ctx).found);
}

TEST(FindRoute, SaysWhyThereIsNone) {
  base::RunContext ctx;
  EXPECT_EQ(find_route(map_of({"#.."}), {0, 0}, {0, 2}, kShortest, ctx).reason, "start_blocked");
  EXPECT_EQ(find_route(map_of({"..#"}), {0, 0}, {0, 2}, kShortest, ctx).reason, "goal_blocked");
  EXPECT_EQ(find_route(map_of({".#."}), {0, 0}, {0, 2}, kShortest, ctx).reason, "no_path");
  EXPECT_EQ(find_route(map_of({".?."}), {0, 0}, {0, 2}, kShortest, ctx).reason, "no_path");
  EXPECT_TRUE(find_route(map_of({".?."}), {0, 0}, {0, 2}, {0.0, true}, ctx).found);
  EXPECT_EQ(find_route(map_of({"..."}), {0, 0}, {5, 2}, kShortest, ctx).reason, "goal_blocked");
}

TEST(FindRoute, IsOptimalOnRandomMaps) {
  base::Random random(1, "route", 0);
  base::RunContext ctx;
  int found = 0;
  for (int trial = 0; trial < 60; ++trial) {
    Grid<std::uint8_t> cost({0.0, 0.0, 1.0, 3 + random.below(20), 3 + random.below(20)}, 0);
    for (auto& v : cost.values)
      v = random.uniform() < 0.3 ? kLethal : static_cast<std::uint8_t>(trial % 2 == 0 ? 0 : random.below(253));
    const Cell start{random.below(cost.geometry.rows), random.below(cost.geometry.columns)};
    const Cell goal{random.below(cost.geometry.rows), random.below(cost.geometry.columns)};
    cost.at(start.first, start.second) = 0;
    cost.at(goal.first, goal.second) = 0;
    const double weight = trial % 2 == 0 ? 0.0 : 5.0;
    const auto route = find_route(cost, start, goal, {weight, false}, ctx);
    const double expected = testing::dijkstra(cost, start, goal, weight);
    ASSERT_EQ(route.found, std::isfinite(expected));
    if (!route.found) continue;
    ++found;
    EXPECT_NEAR(route.weighted_length_m, expected, kLengthTol);
    EXPECT_EQ(route.path.front(), cost.geometry.centre(start.first, start.second));
    EXPECT_EQ(route.path.back(), cost.geometry.centre(goal.first, goal.second));
  }
  EXPECT_GT(found, 20);
}

TEST(FarApart, EndsLieInTheLargestRegion) {
  const auto cost = map_of({".#......", ".#.####.", "##.#..#.", ".......#"});
  const auto ends = far_apart(cost, kShortest);
  ASSERT_TRUE(ends);
  base::RunContext ctx;
  EXPECT_TRUE(find_route(cost, ends->first, ends->second, kShortest, ctx).found);
  EXPECT_FALSE(far_apart(map_of({"##"}), kShortest));
}

TEST(WithoutCollinear, KeepsCornersOnly) {
  const std::vector<geometry::Vec2> path{{0, 0}, {1, 0}, {2, 0}, {3, 1}, {4, 2}, {4, 3}};
  EXPECT_EQ(without_collinear(path), (std::vector<geometry::Vec2>{{0, 0}, {2, 0}, {4, 2}, {4, 3}}));
}

}  // namespace
}  // namespace cairn::ground
