#include "ground/occupancy.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/random.hpp"
#include "ground/resampling.hpp"

namespace cairn::ground {
namespace {

using geometry::GridGeometry;
using geometry::Ring;
using geometry::Vec2;
using ::testing::ElementsAre;
constexpr auto kFree = Occupancy::free, kOccupied = Occupancy::occupied, kUnknownCell = Occupancy::unknown;

std::size_t count(const OccupancyGrid& grid, Occupancy value) {
  return static_cast<std::size_t>(std::count(grid.values.begin(), grid.values.end(), value));
}

survey::Obstacle obstacle_at(double east, double north, double width, survey::ObstacleKind kind) {
  survey::Obstacle o;
  o.position = {east, north, 0.0};
  o.width_m = width;
  o.kind = kind;
  return o;
}

TEST(MarkObstacles, DiscsOfObstaclesOnly) {
  OccupancyGrid grid({0.0, 10.0, 0.1, 100, 100}, kFree);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<survey::Obstacle> obstacles{obstacle_at(5.0, 5.0, 2.0, survey::ObstacleKind::obstacle),
                                                obstacle_at(2.0, 2.0, 1.0, survey::ObstacleKind::ignored),
                                                obstacle_at(8.0, 8.0, 1.0, survey::ObstacleKind::vehicle),
                                                obstacle_at(1.02, 9.02, 0.0, survey::ObstacleKind::obstacle),
                                                obstacle_at(50.0, 5.0, 1.0, survey::ObstacleKind::obstacle),
                                                obstacle_at(kNan, 5.0, 1.0, survey::ObstacleKind::obstacle)};
  const MarkedObstacles marked = mark_obstacles(obstacles, grid);
  EXPECT_THAT(marked.outside, ElementsAre(4U));
  EXPECT_THAT(marked.not_finite, ElementsAre(5U));
  EXPECT_EQ(marked.cells, (CellRegion{9, 10, 51, 50}));
  // A disc of radius 1 m, and one cell for the obstacle without width.
  constexpr double kGridding = 0.02;  // of the area: cells of 0.1 m on a circle of 1 m
  EXPECT_NEAR(static_cast<double>(count(grid, kOccupied)) * 0.01, 3.14159265 + 0.01, kGridding * 3.2);
  EXPECT_EQ(grid.at(80, 20), kFree);
  EXPECT_EQ(grid.at(9, 10), kOccupied);
}

TEST(MarkPolygon, CellsWhoseCentreLiesInside) {
  base::Random random(1, "polygon", 0);
  for (int trial = 0; trial < 20; ++trial) {
    OccupancyGrid grid({-3.0, 4.0, 0.25, 30, 26}, kFree);
    Ring outer, hole;
    for (int i = 0; i < 7; ++i) outer.push_back({random.uniform(-4.0, 5.0), random.uniform(-3.0, 5.0)});
    for (int i = 0; i < 3; ++i) hole.push_back({random.uniform(-2.0, 2.0), random.uniform(-1.0, 3.0)});
    (void)mark_polygon(std::vector<Ring>{outer, hole}, kOccupied, grid);
    for (std::size_t r = 0; r < 26; ++r)
      for (std::size_t c = 0; c < 30; ++c) {
        const Vec2 p = grid.geometry.centre(r, c);
        const bool inside = geometry::contains(outer, p) != geometry::contains(hole, p);
        ASSERT_EQ(grid.at(r, c) == kOccupied, inside) << r << "," << c;
      }
  }
  OccupancyGrid grid({0.0, 1.0, 0.5, 2, 2}, kFree);
  EXPECT_FALSE(mark_polygon(std::vector<Ring>{{{5, 5}, {6, 5}, {6, 6}}}, kOccupied, grid));
}

// The whole truth table of the documented rule.
TEST(Combine, FollowsTheRuleForEverySource) {
  const CombineOptions defaults;
  for (const auto prior : {kFree, kOccupied, kUnknownCell})
    for (const auto obstacle : {kFree, kOccupied, kUnknownCell})
      for (const auto scan : {kFree, kOccupied, kUnknownCell}) {
        const auto got = combine(prior, obstacle, scan, defaults);
        if (prior == kOccupied || obstacle == kOccupied || scan == kOccupied) EXPECT_EQ(got, kOccupied);
        else if (prior == kFree || scan == kFree) EXPECT_EQ(got, kFree);
        else EXPECT_EQ(got, kUnknownCell);
      }
  EXPECT_EQ(combine(kOccupied, kUnknownCell, kFree, {true, true, false}), kFree);
  EXPECT_EQ(combine(kOccupied, kOccupied, kFree, {true, true, false}), kOccupied);
  EXPECT_EQ(combine(kFree, kOccupied, kFree, {true, false, true}), kFree);
  EXPECT_EQ(combine(kUnknownCell, kOccupied, kFree, {true, false, true}), kFree);
  EXPECT_EQ(combine(kUnknownCell, kUnknownCell, kFree, {false, false, false}), kUnknownCell);
  EXPECT_EQ(combine(kUnknownCell, kUnknownCell, kUnknownCell, {true, true, true}), kUnknownCell);
}

TEST(Combine, WritesTheRegionOnlyAndRefusesOtherGrids) {
  const GridGeometry g{0.0, 4.0, 1.0, 4, 4};
  const OccupancyGrid prior(g, kFree);
  OccupancyGrid scans(g, kOccupied), out(g, kUnknownCell);
  combine(prior, nullptr, &scans, {}, {1, 2, 2, 1}, out);
  EXPECT_EQ(count(out, kOccupied), 2U);
  EXPECT_EQ(out.at(1, 2), kOccupied);
  EXPECT_EQ(out.at(2, 2), kOccupied);
  scans.geometry.west = 0.5;
  EXPECT_THROW(combine(prior, nullptr, &scans, {}, whole(g), out), base::Error);
}

TEST(Resampled, FinerKeepsTheCellAroundAndCoarserLosesNoObstacle) {
  OccupancyGrid grid({2.0, 3.0, 0.1, 6, 4}, kFree);
  grid.at(1, 2) = kOccupied;
  grid.at(3, 5) = kUnknownCell;
  const OccupancyGrid fine = resampled(grid, {2.0, 3.0, 0.05, 12, 8});
  for (std::size_t r = 0; r < 8; ++r)
    for (std::size_t c = 0; c < 12; ++c) EXPECT_EQ(fine.at(r, c), grid.at(r / 2, c / 2));
  const OccupancyGrid coarse = resampled(grid, {2.0, 3.0, 0.2, 3, 2});
  EXPECT_THAT(coarse.values, ElementsAre(kFree, kOccupied, kFree, kFree, kFree, kUnknownCell));
  // Shifted by half a cell, one column and one row beyond.
  const OccupancyGrid shifted = resampled(grid, {2.05, 3.05, 0.1, 6, 4});
  EXPECT_EQ(shifted.at(0, 0), kUnknownCell);
  EXPECT_EQ(shifted.at(1, 1), kOccupied);
  EXPECT_EQ(shifted.at(2, 2), kOccupied);
  EXPECT_EQ(shifted.at(3, 3), kFree);
  EXPECT_EQ(shifted.at(2, 5), kUnknownCell);
  EXPECT_EQ(resampled(grid, grid.geometry).values, grid.values);
}

TEST(Resampled, StripByStripIsTheWhole) {
  base::Random random(2, "resampling", 0);
  OccupancyGrid grid({0.0, 3.0, 0.07, 40, 43}, kFree);
  for (auto& v : grid.values) v = static_cast<Occupancy>(random.below(3));
  const GridGeometry to{-0.11, 3.2, 0.05, 60, 70};
  const OccupancyGrid at_once = resampled(grid, to);
  const Resampling resampling(grid.geometry, to);
  EXPECT_FALSE(resampling.aligned());
  EXPECT_TRUE(Resampling(grid.geometry, {0.14, 2.93, 0.07, 5, 5}).aligned());
  for (std::size_t first = 0; first < 70; first += 13) {
    OccupancyGrid strip({0, 0, 0.05, 60, std::min<std::size_t>(13, 70 - first)}, kFree);
    const auto [begin, end] = resampling.rows_needed(first, strip.geometry.rows);
    OccupancyGrid window({0, 0, 0.07, 40, end - begin}, kFree);
    for (std::size_t r = begin; r < end; ++r)
      for (std::size_t c = 0; c < 40; ++c) window.at(r - begin, c) = grid.at(r, c);
    resampling.rows(window, begin, first, strip);
    for (std::size_t r = 0; r < strip.geometry.rows; ++r)
      for (std::size_t c = 0; c < 60; ++c) ASSERT_EQ(strip.at(r, c), at_once.at(first + r, c));
  }
}

TEST(Resampled, TurnedByNothingAndByRightAnglesIsExact) {
  base::Random random(3, "resampling", 0);
  OccupancyGrid grid({1.0, 3.0, 0.5, 5, 4}, kFree);
  for (auto& v : grid.values) v = static_cast<Occupancy>(random.below(3));
  EXPECT_EQ(resampled_turned(grid, 0.0, grid.geometry).values, grid.values);
  // Counter-clockwise by 90 deg about (1, 1): east becomes north, north becomes west.
  const double quarter = std::acos(0.0);
  const GridGeometry around{-1.0, 3.5, 0.5, 4, 5};
  const OccupancyGrid turned = resampled_turned(grid, quarter, around);
  for (std::size_t r = 0; r < 4; ++r)
    for (std::size_t c = 0; c < 5; ++c) EXPECT_EQ(turned.at(4 - c, r), grid.at(r, c));
  EXPECT_EQ(grid_around_turned(grid.geometry, 0.0, 0.5), grid.geometry);
}

// Every obstacle point lies in an occupied cell, every free cell holds free points only.
TEST(Resampled, TurnedMapLosesNoObstacle) {
  base::Random random(4, "resampling", 0);
  OccupancyGrid grid({2.0, 4.0, 0.1, 10, 10}, kFree);
  for (auto& v : grid.values) v = random.uniform() < 0.1 ? kOccupied : kFree;
  for (const double yaw : {1.0, -2.5, 0.3}) {
    const GridGeometry around = grid_around_turned(grid.geometry, yaw, 0.05);
    const OccupancyGrid turned = resampled_turned(grid, yaw, around);
    for (int point = 0; point < 3000; ++point) {
      const Vec2 local(random.uniform(0.0, 1.0), random.uniform(0.0, 1.0));
      const Vec2 world = Vec2(2.0, 3.0) + Vec2(std::cos(yaw) * local.x() - std::sin(yaw) * local.y(),
                                               std::sin(yaw) * local.x() + std::cos(yaw) * local.y());
      const auto from = grid.geometry.cell_at(Vec2(2.0, 3.0) + local);
      const auto to = around.cell_at(world);
      ASSERT_TRUE(from && to);
      const Occupancy in = grid.at(from->first, from->second), out = turned.at(to->first, to->second);
      ASSERT_TRUE(in != kOccupied || out == kOccupied);
      ASSERT_TRUE(out != kFree || in == kFree);
    }
    EXPECT_GT(count(turned, kFree), 100U);
  }
}

TEST(CellRegions, WidenJoinAndClip) {
  const GridGeometry g{0.0, 10.0, 0.5, 20, 20};
  EXPECT_EQ(cells_of(g, {1.0, 1.0}, {1.9, 1.9}), (CellRegion{16, 2, 3, 2}));
  EXPECT_TRUE(cells_of(g, {11.0, 0.0}, {12.0, 1.0}).empty());
  EXPECT_EQ(cells_of(g, {-5.0, -5.0}, {50.0, 50.0}), whole(g));
  EXPECT_EQ(widened({1, 18, 1, 1}, 2, g), (CellRegion{0, 16, 4, 4}));
  EXPECT_TRUE(widened({}, 3, g).empty());
  EXPECT_EQ(joined({1, 1, 1, 1}, {4, 0, 2, 1}), (CellRegion{1, 0, 5, 2}));
}

}  // namespace
}  // namespace cairn::ground
