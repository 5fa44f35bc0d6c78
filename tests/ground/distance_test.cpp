#include "ground/distance.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/random.hpp"

namespace cairn::ground {
namespace {

using geometry::Grid;

Grid<std::uint8_t> random_map(base::Random& random, std::size_t columns, std::size_t rows, double share) {
  Grid<std::uint8_t> map({0.0, 0.0, 1.0, columns, rows}, 0);
  for (auto& v : map.values) v = random.uniform() < share ? 1 : 0;
  return map;
}

std::int32_t brute_force(const Grid<std::uint8_t>& map, std::size_t row, std::size_t column, int reach) {
  std::int64_t best = std::int64_t{reach} * reach + 1;
  for (std::size_t r = 0; r < map.geometry.rows; ++r)
    for (std::size_t c = 0; c < map.geometry.columns; ++c) {
      if (map.at(r, c) == 0) continue;
      const std::int64_t dr = static_cast<std::int64_t>(r) - static_cast<std::int64_t>(row);
      const std::int64_t dc = static_cast<std::int64_t>(c) - static_cast<std::int64_t>(column);
      best = std::min(best, dr * dr + dc * dc);
    }
  return static_cast<std::int32_t>(best);
}

TEST(SquaredDistance, EqualsBruteForceOnRandomMaps) {
  base::Random random(1, "distance", 0);
  for (int trial = 0; trial < 60; ++trial) {
    const double share = trial % 3 == 0 ? 0.002 : (trial % 3 == 1 ? 0.05 : 0.6);
    const auto map = random_map(random, 1 + random.below(45), 1 + random.below(45), share);
    const int reach = trial % 2 == 0 ? 5 : 100;
    const auto distance = squared_distance(map, reach);
    for (std::size_t r = 0; r < map.geometry.rows; ++r)
      for (std::size_t c = 0; c < map.geometry.columns; ++c)
        ASSERT_EQ(distance.at(r, c), brute_force(map, r, c, reach)) << r << "," << c << " reach " << reach;
  }
}

TEST(SquaredDistance, EmptyMapIsFarEverywhere) {
  const Grid<std::uint8_t> map({0, 0, 1, 7, 3}, 0);
  for (const auto v : squared_distance(map, 10).values) EXPECT_EQ(v, 101);
}

TEST(SquaredDistance, SameForAnyThreadCount) {
  base::Random random(2, "distance", 0);
  const auto map = random_map(random, 1500, 700, 0.01);
  Grid<std::int32_t> reference;
  for (const int threads : {1, 4}) {
    const base::ThreadLimit limit(threads);
    const auto distance = squared_distance(map, 60);
    if (threads == 1) reference = distance;
    EXPECT_EQ(distance.values, reference.values);
  }
}

TEST(SquaredDistance, RefusesImpossibleReach) {
  const Grid<std::uint8_t> map({0, 0, 1, 2, 2}, 0);
  EXPECT_THROW((void)squared_distance(map, 0), base::Error);
  EXPECT_THROW((void)squared_distance(map, 40000), base::Error);
}

}  // namespace
}  // namespace cairn::ground
