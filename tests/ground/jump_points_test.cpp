#include "ground/jump_points.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/random.hpp"
#include "ground/dijkstra.hpp"

namespace cairn::ground {
namespace {

using geometry::Grid;

constexpr double kLengthTol = 1e-9;  // cells; the oracle sums a few hundred roundings

std::vector<std::uint8_t> blocked_values() {
  std::vector<std::uint8_t> blocked(256, 0);
  for (std::size_t i = kInscribed; i < 256; ++i) blocked[i] = 1;
  return blocked;
}

TEST(BlockedBits, HoldTheMapBothWaysWithinABorder) {
  base::Random random(3, "bits", 0);
  for (const std::size_t columns : {1U, 61U, 62U, 63U, 64U, 65U, 130U}) {
    Grid<std::uint8_t> cost({0.0, 0.0, 1.0, columns, 70}, 0);
    for (auto& value : cost.values) value = random.uniform() < 0.4 ? kLethal : 0;
    const BlockedBits bits(cost, blocked_values());
    for (std::int64_t r = -1; r <= 70; ++r)
      for (std::int64_t c = -1; c <= static_cast<std::int64_t>(columns); ++c) {
        const bool border = r < 0 || c < 0 || r == 70 || c == static_cast<std::int64_t>(columns);
        const bool expected = border || cost.at(static_cast<std::size_t>(r), static_cast<std::size_t>(c)) == kLethal;
        ASSERT_EQ(bits.blocked(r + 1, c + 1), expected) << r << " " << c;
        const std::uint64_t word = bits.columns.line(c + 1)[(r + 1) >> 6];
        ASSERT_EQ((word >> ((r + 1) & 63) & 1) != 0, expected) << r << " " << c;
      }
  }
}

// Clumps of blocked cells, so that there are long scans and corners of every kind.
Grid<std::uint8_t> clumps(base::Random& random) {
  Grid<std::uint8_t> cost({0.0, 0.0, 1.0, 1 + random.below(200), 1 + random.below(90)}, 0);
  const auto rows = cost.geometry.rows, columns = cost.geometry.columns;
  const std::size_t count = random.below(1 + rows * columns / 12);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t r = random.below(rows), c = random.below(columns), h = 1 + random.below(6),
                      w = 1 + random.below(6);
    for (std::size_t y = r; y < std::min(rows, r + h); ++y)
      for (std::size_t x = c; x < std::min(columns, c + w); ++x)
        if (random.uniform() < 0.7) cost.at(y, x) = kLethal;
  }
  return cost;
}

TEST(JumpPath, IsAsShortAsDijkstrasOnRandomMaps) {
  base::Random random(1, "jump", 0);
  base::RunContext ctx;
  int found = 0;
  for (int trial = 0; trial < 300; ++trial) {
    auto cost = clumps(random);
    const BlockedBits bits(cost, blocked_values());
    for (int query = 0; query < 4; ++query) {
      const Cell start{random.below(cost.geometry.rows), random.below(cost.geometry.columns)};
      const Cell goal{random.below(cost.geometry.rows), random.below(cost.geometry.columns)};
      if (cost.at(start.first, start.second) != 0 || cost.at(goal.first, goal.second) != 0) continue;
      const auto path = jump_path(bits, start, goal, ctx);
      const double expected = testing::dijkstra(cost, start, goal, 0.0);
      ASSERT_EQ(!path.corners.empty(), std::isfinite(expected));
      if (path.corners.empty()) continue;
      ++found;
      ASSERT_NEAR(static_cast<double>(path.straight) + std::numbers::sqrt2 * static_cast<double>(path.diagonal),
                  expected, kLengthTol);
    }
  }
  EXPECT_GT(found, 300);
}

}  // namespace
}  // namespace cairn::ground
