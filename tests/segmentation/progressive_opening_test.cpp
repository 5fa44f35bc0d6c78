#include "segmentation/progressive_opening.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/random.hpp"
#include "segmentation/grid_fill.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Grid;
using geometry::GridGeometry;

constexpr GridGeometry kGrid{0.0, 30.0, 0.5, 70, 60};

TEST(ObjectCells, SlopesAreKeptAndBlocksAreCutOff) {
  Grid<float> heights(kGrid, 0.0F);
  for (std::size_t r = 0; r < kGrid.rows; ++r)
    for (std::size_t c = 0; c < kGrid.columns; ++c)
      heights.at(r, c) = 0.4F * static_cast<float>(c) - 0.3F * static_cast<float>(r);  // steeper than 40 deg
  const auto none = object_cells(heights, 8, 0.15);
  EXPECT_EQ(std::count(none.values.begin(), none.values.end(), 1), 0);

  for (std::size_t r = 20; r < 29; ++r)
    for (std::size_t c = 30; c < 37; ++c) heights.at(r, c) += 4.0F;
  const auto found = object_cells(heights, 8, 0.15);
  for (std::size_t r = 0; r < kGrid.rows; ++r)
    for (std::size_t c = 0; c < kGrid.columns; ++c)
      EXPECT_EQ(found.at(r, c), r >= 20 && r < 29 && c >= 30 && c < 37 ? 1 : 0) << r << ' ' << c;
  // A window of 5 cells is narrower than a block on level ground: nothing is cut off. (Of a tilted roof it takes the
  // upper edge.)
  Grid<float> level(kGrid, 1.0F);
  for (std::size_t r = 20; r < 29; ++r)
    for (std::size_t c = 30; c < 37; ++c) level.at(r, c) = 5.0F;
  const auto narrow = object_cells(level, 2, 0.15);
  EXPECT_EQ(std::count(narrow.values.begin(), narrow.values.end(), 1), 0);
}

// Oracle: the definition, with openings of grid_fill.hpp, away from the border (theirs ends there).
TEST(ObjectCells, AgreesWithTheDefinition) {
  base::Random random(5, "cells", 0);
  Grid<float> heights(kGrid, 0.0F);
  for (float& z : heights.values) z = static_cast<float>(random.uniform(0.0, 1.5));
  constexpr std::size_t kRadius = 7;
  const auto found = object_cells(heights, kRadius, 0.2);
  Grid<float> before = heights;
  Grid<std::uint8_t> expected(kGrid, 0);
  for (const std::size_t r : {1U, 2U, 3U, 4U, 5U, 6U, 7U}) {
    const Grid<float> now = opened(heights, r);
    for (std::size_t k = 0; k < expected.values.size(); ++k)
      if (before.values[k] - now.values[k] > static_cast<float>(0.2 * 0.5 * static_cast<double>(r)))
        expected.values[k] = 1;
    before = now;
  }
  std::size_t objects = 0;
  for (std::size_t r = 2 * kRadius; r < kGrid.rows - 2 * kRadius; ++r)
    for (std::size_t c = 2 * kRadius; c < kGrid.columns - 2 * kRadius; ++c) {
      EXPECT_EQ(found.at(r, c), expected.at(r, c)) << r << ' ' << c;
      objects += found.at(r, c);
    }
  EXPECT_GT(objects, 50U);
}

}  // namespace
}  // namespace cairn::segmentation
