#include "ground/costmap.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.hpp"
#include "base/random.hpp"

namespace cairn::ground {
namespace {

using geometry::Grid;

// papers.md section 8: D - R = 1 m gives 12.546, 0.5 m gives 56.229, below 1 from 1.843 m.
TEST(CostAt, TruncatesEquationNine) {
  const CostmapOptions o{0.35, 3.0, 0.05};
  EXPECT_EQ(cost_at(0.0, o), 254);
  EXPECT_EQ(cost_at(0.05, o), 253);
  EXPECT_EQ(cost_at(0.35, o), 253);
  EXPECT_EQ(cost_at(0.85, o), 56);
  EXPECT_EQ(cost_at(1.35, o), 12);
  EXPECT_EQ(cost_at(0.35 + 1.842, o), 1);
  EXPECT_EQ(cost_at(0.35 + 1.844, o), 0);
}

TEST(Costmap, EqualsBruteForceToTheByte) {
  base::Random random(1, "costmap", 0);
  for (int trial = 0; trial < 20; ++trial) {
    const CostmapOptions o{random.uniform(0.0, 1.0), random.uniform(1.0, 5.0), 0.1};
    Grid<std::uint8_t> occupancy({-2.0, 3.0, 0.1, 50, 40}, 0);
    for (auto& v : occupancy.values) {
      const double u = random.uniform();
      v = u < 0.01 ? 1 : (u < 0.05 ? 2 : 0);
    }
    const auto cost = costmap(occupancy, o);
    for (std::size_t r = 0; r < 40; ++r)
      for (std::size_t c = 0; c < 50; ++c) {
        if (occupancy.at(r, c) == 2) {
          ASSERT_EQ(cost.at(r, c), kUnknown);
          continue;
        }
        double nearest = 1e9;
        for (std::size_t i = 0; i < 40; ++i)
          for (std::size_t j = 0; j < 50; ++j)
            if (occupancy.at(i, j) == 1) {
              const auto dr = static_cast<double>(i) - static_cast<double>(r);
              const auto dc = static_cast<double>(j) - static_cast<double>(c);
              nearest = std::min(nearest, std::sqrt(dr * dr + dc * dc) * o.resolution_m);
            }
        ASSERT_EQ(cost.at(r, c), cost_at(nearest, o)) << r << "," << c;
      }
  }
}

survey::Obstacle obstacle_at(double east, double north, double width, survey::ObstacleKind kind) {
  survey::Obstacle o;
  o.position = {east, north, 0.0};
  o.width_m = width;
  o.kind = kind;
  return o;
}

TEST(MarkObstacles, DiscsOfObstaclesOnly) {
  Grid<std::uint8_t> occupancy({0.0, 10.0, 0.1, 100, 100}, 0);
  const auto outside = mark_obstacles({obstacle_at(5.0, 5.0, 2.0, survey::ObstacleKind::obstacle),
                                       obstacle_at(2.0, 2.0, 1.0, survey::ObstacleKind::ignored),
                                       obstacle_at(8.0, 8.0, 1.0, survey::ObstacleKind::vehicle),
                                       obstacle_at(1.02, 9.02, 0.0, survey::ObstacleKind::obstacle),
                                       obstacle_at(50.0, 5.0, 1.0, survey::ObstacleKind::obstacle)},
                                      occupancy);
  EXPECT_THAT(outside, ::testing::ElementsAre(4U));
  double cells = 0.0;
  for (const auto v : occupancy.values) cells += v;
  // A disc of radius 1 m, and one cell for the obstacle without width.
  constexpr double kGridding = 0.02;  // of the area: cells of 0.1 m on a circle of 1 m
  EXPECT_NEAR(cells * 0.01, 3.14159265 + 0.01, kGridding * 3.2);
  EXPECT_EQ(occupancy.at(80, 20), 0);
  EXPECT_EQ(occupancy.at(9, 10), 1);
}

TEST(Costmap, RefusesAnotherResolution) {
  const Grid<std::uint8_t> occupancy({0, 0, 0.1, 3, 3}, 0);
  EXPECT_THROW((void)costmap(occupancy, {0.35, 3.0, 0.05}), base::Error);
}

}  // namespace
}  // namespace cairn::ground
