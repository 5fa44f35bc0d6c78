#include "ground/costmap.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/random.hpp"

namespace cairn::ground {
namespace {

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
    OccupancyGrid occupancy({-2.0, 3.0, 0.1, 50, 40}, Occupancy::free);
    for (auto& v : occupancy.values) {
      const double u = random.uniform();
      v = u < 0.01 ? Occupancy::occupied : (u < 0.05 ? Occupancy::unknown : Occupancy::free);
    }
    const auto cost = costmap(occupancy, o);
    for (std::size_t r = 0; r < 40; ++r)
      for (std::size_t c = 0; c < 50; ++c) {
        if (occupancy.at(r, c) == Occupancy::unknown) {
          ASSERT_EQ(cost.at(r, c), kUnknown);
          continue;
        }
        double nearest = 1e9;
        for (std::size_t i = 0; i < 40; ++i)
          for (std::size_t j = 0; j < 50; ++j)
            if (occupancy.at(i, j) == Occupancy::occupied) {
              const auto dr = static_cast<double>(i) - static_cast<double>(r);
              const auto dc = static_cast<double>(j) - static_cast<double>(c);
              nearest = std::min(nearest, std::sqrt(dr * dr + dc * dc) * o.resolution_m);
            }
        ASSERT_EQ(cost.at(r, c), cost_at(nearest, o)) << r << "," << c;
      }
  }
}

// Random discs and lone cells, some ground unknown: large enough for several strips and blocks.
OccupancyGrid random_grid(base::Random& random, std::size_t columns, std::size_t rows) {
  OccupancyGrid grid({0.0, 0.0, 0.05, columns, rows}, Occupancy::free);
  for (int disc = 0; disc < 12; ++disc) {
    const double radius = random.uniform(0.0, 0.6);
    const geometry::Vec2 at(random.uniform(0.0, grid.geometry.east()), random.uniform(grid.geometry.south(), 0.0));
    const Occupancy value = disc % 4 == 3 ? Occupancy::unknown : Occupancy::occupied;
    const CellRegion near =
        cells_of(grid.geometry, at - geometry::Vec2::Constant(radius), at + geometry::Vec2::Constant(radius));
    for (std::size_t r = near.row; r < near.end_row(); ++r)
      for (std::size_t c = near.column; c < near.end_column(); ++c)
        if ((grid.geometry.centre(r, c) - at).norm() <= radius) grid.at(r, c) = value;
  }
  return grid;
}

// Every pair of cells within the reach; the cost of what lies beyond is 0 by equation (9).
std::uint8_t brute_force(const OccupancyGrid& grid, std::size_t row, std::size_t column, const CostmapOptions& o) {
  if (grid.at(row, column) == Occupancy::unknown) return kUnknown;
  const CellRegion near = widened({row, column, 1, 1}, static_cast<std::size_t>(reach_cells(o)), grid.geometry);
  double nearest = 1e9;
  for (std::size_t i = near.row; i < near.end_row(); ++i)
    for (std::size_t j = near.column; j < near.end_column(); ++j) {
      if (grid.at(i, j) != Occupancy::occupied) continue;
      const auto dr = static_cast<double>(i) - static_cast<double>(row);
      const auto dc = static_cast<double>(j) - static_cast<double>(column);
      nearest = std::min(nearest, std::hypot(dr, dc) * o.resolution_m);
    }
  return cost_at(nearest, o);
}

TEST(Costmap, EqualsBruteForceAcrossStripsAndBlocks) {
  base::Random random(2, "costmap", 0);
  // Reaches of 45 (the default), 30 and 2 cells take the fast way; 194 cells the general one.
  for (const CostmapOptions& o : {CostmapOptions{0.35, 3.0, 0.05}, CostmapOptions{0.0, 4.0, 0.05},
                                  CostmapOptions{0.01, 100.0, 0.05}, CostmapOptions{4.1, 1.0, 0.05}}) {
    const OccupancyGrid grid = random_grid(random, 331, 300);
    const auto cost = costmap(grid, o);
    for (int check = 0; check < 4000; ++check) {
      const std::size_t r = random.below(300), c = random.below(331);
      ASSERT_EQ(cost.at(r, c), brute_force(grid, r, c, o)) << r << "," << c << " R " << o.radius_m;
    }
  }
}

TEST(Costmap, SameBytesForAnyThreadCount) {
  base::Random random(3, "costmap", 0);
  const OccupancyGrid grid = random_grid(random, 700, 1100);
  geometry::Grid<std::uint8_t> reference;
  for (const int threads : {1, 4}) {
    const base::ThreadLimit limit(threads);
    const auto cost = costmap(grid, {});
    if (threads == 1) reference = cost;
    EXPECT_EQ(cost.values, reference.values);
  }
}

TEST(Costmap, UpdateOfARegionGivesTheBytesOfTheWhole) {
  base::Random random(4, "costmap", 0);
  OccupancyGrid grid = random_grid(random, 400, 350);
  auto cost = costmap(grid, {});
  for (int change = 0; change < 20; ++change) {
    const CellRegion region{random.below(340), random.below(390), 1 + random.below(10), 1 + random.below(10)};
    const auto value = static_cast<Occupancy>(random.below(3));
    for (std::size_t r = region.row; r < region.end_row(); ++r)
      for (std::size_t c = region.column; c < region.end_column(); ++c) grid.at(r, c) = value;
    const CellRegion written = update_costmap(grid, region, {}, cost);
    EXPECT_EQ(written, widened(region, 45, grid.geometry));
    ASSERT_EQ(cost.values, costmap(grid, {}).values);
  }
  EXPECT_TRUE(update_costmap(grid, {}, {}, cost).empty());
  EXPECT_THROW((void)update_costmap(grid, {345, 0, 10, 1}, {}, cost), base::Error);
}

TEST(Costmap, RefusesAnotherResolution) {
  const OccupancyGrid occupancy({0, 0, 0.1, 3, 3}, Occupancy::free);
  EXPECT_THROW((void)costmap(occupancy, {0.35, 3.0, 0.05}), base::Error);
}

}  // namespace
}  // namespace cairn::ground
