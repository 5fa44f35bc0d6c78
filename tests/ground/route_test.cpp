#include "ground/route.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/random.hpp"
#include "ground/costmap.hpp"

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

// Oracle: Bellman-Ford relaxation until nothing changes.
double brute_force(const Grid<std::uint8_t>& cost, const Cell& start, const Cell& goal, double weight) {
  const auto rows = static_cast<int>(cost.geometry.rows), columns = static_cast<int>(cost.geometry.columns);
  const auto at = [&](int r, int c) { return cost.values[static_cast<std::size_t>(r * columns + c)]; };
  const auto free = [&](int r, int c) { return r >= 0 && c >= 0 && r < rows && c < columns && at(r, c) < kInscribed; };
  const auto factor = [&](int r, int c) { return 1.0 + weight * at(r, c) / 252.0; };
  std::vector<double> best(cost.values.size(), std::numeric_limits<double>::infinity());
  best[start.first * cost.geometry.columns + start.second] = 0.0;
  for (bool changed = true; changed;) {
    changed = false;
    for (int r = 0; r < rows; ++r)
      for (int c = 0; c < columns; ++c) {
        if (!free(r, c)) continue;
        for (int dr = -1; dr <= 1; ++dr)
          for (int dc = -1; dc <= 1; ++dc) {
            if ((dr == 0 && dc == 0) || !free(r + dr, c + dc)) continue;
            if (dr != 0 && dc != 0 && (!free(r + dr, c) || !free(r, c + dc))) continue;
            const double step = std::sqrt(static_cast<double>(dr * dr + dc * dc));
            const double d = best[static_cast<std::size_t>((r + dr) * columns + c + dc)] +
                             step * 0.5 * (factor(r, c) + factor(r + dr, c + dc));
            auto& here = best[static_cast<std::size_t>(r * columns + c)];
            if (d < here - 1e-12) {
              here = d;
              changed = true;
            }
          }
      }
  }
  return best[goal.first * cost.geometry.columns + goal.second];
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
    const double expected = brute_force(cost, start, goal, weight);
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
