#include "geometry/grid.hpp"

#include <gtest/gtest.h>

namespace cairn::geometry {
namespace {

TEST(Grid, RowsRunNorthToSouth) {
  const GridGeometry g{10.0, 100.0, 0.5, 4, 3};
  EXPECT_EQ(g.east(), 12.0);
  EXPECT_EQ(g.south(), 98.5);
  EXPECT_EQ(g.centre(0, 0), Vec2(10.25, 99.75));
  EXPECT_EQ(g.centre(2, 3), Vec2(11.75, 98.75));
}

TEST(Grid, CellAtInvertsCentre) {
  const GridGeometry g{-3.0, 7.0, 0.25, 17, 9};
  for (std::size_t r = 0; r < g.rows; ++r)
    for (std::size_t c = 0; c < g.columns; ++c) EXPECT_EQ(g.cell_at(g.centre(r, c)), std::pair(r, c));
  EXPECT_FALSE(g.cell_at({-3.001, 6.0}));
  EXPECT_FALSE(g.cell_at({g.east(), 6.0}));
  EXPECT_FALSE(g.cell_at({0.0, std::nan("")}));
}

TEST(Grid, CoveringGridIsAlignedAndCovers) {
  const GridGeometry g = covering_grid({-1.2, 3.4}, {2.05, 9.99}, 0.5);
  EXPECT_EQ(g.west, -1.5);
  EXPECT_EQ(g.north, 10.0);
  EXPECT_GE(g.east(), 2.05);
  EXPECT_LE(g.south(), 3.4);
  EXPECT_LT(g.east() - 2.05, 0.5);
}

}  // namespace
}  // namespace cairn::geometry
