#include "segmentation/grid_fill.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.hpp"
#include "base/random.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Grid;
using geometry::GridGeometry;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Grid<float> random_grid(std::size_t columns, std::size_t rows) {
  base::Random random(9, "grid", 0);
  Grid<float> grid(GridGeometry{0.0, 0.0, 1.0, columns, rows}, 0.0F);
  for (float& v : grid.values) v = static_cast<float>(random.normal());
  return grid;
}

TEST(Opened, EqualsTheDefinition) {
  for (const std::size_t radius : {1U, 2U, 5U, 30U}) {
    const Grid<float> grid = random_grid(23, 17);
    const auto extreme = [radius](const Grid<float>& g, bool lowest) {
      Grid<float> out = g;
      const auto rows = static_cast<long>(g.geometry.rows), columns = static_cast<long>(g.geometry.columns);
      const auto reach = static_cast<long>(radius);
      for (long r = 0; r < rows; ++r)
        for (long c = 0; c < columns; ++c) {
          float best = lowest ? 1e9F : -1e9F;
          for (long i = std::max(0L, r - reach); i <= std::min(rows - 1, r + reach); ++i)
            for (long j = std::max(0L, c - reach); j <= std::min(columns - 1, c + reach); ++j) {
              const float v = g.at(static_cast<std::size_t>(i), static_cast<std::size_t>(j));
              best = lowest ? std::min(best, v) : std::max(best, v);
            }
          out.at(static_cast<std::size_t>(r), static_cast<std::size_t>(c)) = best;
        }
      return out;
    };
    EXPECT_EQ(opened(grid, radius).values, extreme(extreme(grid, true), false).values) << radius;
  }
}

TEST(ClosedMask, ClosesHolesAndKeepsTheBorder) {
  Grid<std::uint8_t> mask(GridGeometry{0.0, 0.0, 1.0, 20, 20}, 0);
  for (std::size_t r = 4; r < 16; ++r)
    for (std::size_t c = 4; c < 16; ++c) mask.at(r, c) = 1;
  for (std::size_t r = 6; r < 8; ++r)
    for (std::size_t c = 6; c < 8; ++c) mask.at(r, c) = 0;  // 2 wide: closed by a reach of 1
  for (std::size_t r = 10; r < 15; ++r)
    for (std::size_t c = 10; c < 15; ++c) mask.at(r, c) = 0;  // 5 wide: stays
  const auto closed = closed_mask(mask, 1);
  for (std::size_t r = 0; r < 20; ++r)
    for (std::size_t c = 0; c < 20; ++c) {
      const bool block = r >= 4 && r < 16 && c >= 4 && c < 16;
      const bool wide = r >= 10 && r < 15 && c >= 10 && c < 15;
      EXPECT_EQ(closed.at(r, c), block && !wide ? 1 : 0) << r << " " << c;
    }
  EXPECT_EQ(closed_mask(mask, 0).values, mask.values);
}

TEST(FillAll, KeepsWhatIsKnownAndFollowsAPlane) {
  Grid<float> grid(GridGeometry{0.0, 0.0, 1.0, 60, 45}, 0.0F);
  const auto plane = [](std::size_t r, std::size_t c) {
    return 0.1F * static_cast<float>(c) - 0.05F * static_cast<float>(r);
  };
  for (std::size_t r = 0; r < 45; ++r)
    for (std::size_t c = 0; c < 60; ++c) grid.at(r, c) = plane(r, c);
  Grid<float> holed = grid;
  for (std::size_t r = 20; r < 27; ++r)
    for (std::size_t c = 30; c < 37; ++c) holed.at(r, c) = kNan;
  fill_all(holed);
  for (std::size_t k = 0; k < grid.values.size(); ++k) {
    const std::size_t r = k / 60, c = k % 60;
    const bool hole = r >= 20 && r < 27 && c >= 30 && c < 37;
    if (!hole) {
      ASSERT_EQ(holed.values[k], grid.values[k]);
    } else {
      ASSERT_NEAR(holed.values[k], grid.values[k], 0.15F);  // a cell and a half of the slope
    }
  }
}

TEST(FillAll, OneKnownCellFillsAllAndNoneFillsNothing) {
  Grid<float> grid(GridGeometry{0.0, 0.0, 1.0, 13, 7}, kNan);
  Grid<float> empty = grid;
  grid.at(3, 5) = 2.5F;
  fill_all(grid);
  for (const float v : grid.values) EXPECT_NEAR(v, 2.5F, 1e-5F);
  fill_all(empty);
  EXPECT_TRUE(std::isnan(empty.values[0]));
}

TEST(FillAll, ThreadsChangeNothing) {
  Grid<float> grid = random_grid(200, 150);
  for (std::size_t k = 0; k < grid.values.size(); ++k)
    if (k % 7 != 0) grid.values[k] = kNan;
  Grid<float> one = grid, four = grid;
  {
    const base::ThreadLimit limit(1);
    fill_all(one);
  }
  {
    const base::ThreadLimit limit(4);
    fill_all(four);
  }
  EXPECT_EQ(one.values, four.values);
}

}  // namespace
}  // namespace cairn::segmentation
