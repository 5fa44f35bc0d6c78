#include "report/raster_image.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "report/palette.hpp"

namespace cairn::report {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

geometry::Grid<float> plane(double east_slope, double north_slope) {
  geometry::Grid<float> grid({0.0, 10.0, 0.5, 20, 20}, 0.0F);
  for (std::size_t r = 0; r < 20; ++r)
    for (std::size_t c = 0; c < 20; ++c) {
      const geometry::Vec2 p = grid.geometry.centre(r, c);
      grid.at(r, c) = static_cast<float>(east_slope * p.x() + north_slope * p.y());
    }
  return grid;
}

// Lambert: level ground under a sun 45 deg high has cosine sin(45 deg) = 0.7071, shade 254 x that.
TEST(Hillshade, level_ground_takes_the_sine_of_the_suns_height) {
  const IndexedImage image = hillshade(plane(0, 0), 315, 45);
  EXPECT_EQ(image.pixels[10 * 20 + 10], std::lround(254 * std::sqrt(0.5)));
}

// A slope of 45 deg that faces the sun (down toward the north, sun in the north at 45 deg) is lit square on,
// its opposite not at all.
TEST(Hillshade, a_slope_facing_the_sun_is_brightest_and_its_back_is_dark) {
  EXPECT_EQ(hillshade(plane(0, -1), 0, 45).pixels[10 * 20 + 10], 254);
  EXPECT_EQ(hillshade(plane(0, 1), 0, 45).pixels[10 * 20 + 10], 0);
  EXPECT_EQ(hillshade(plane(-1, 0), 90, 45).pixels[10 * 20 + 10], 254);
}

TEST(Hillshade, no_data_is_clear) {
  geometry::Grid<float> grid = plane(0, 0);
  grid.at(4, 7) = kNan;
  const IndexedImage image = hillshade(grid, 315, 45);
  EXPECT_EQ(image.palette[image.pixels[4 * 20 + 7]][3], 0);
  EXPECT_EQ(image.palette[image.pixels[4 * 20 + 8]][3], 255);
}

TEST(Shrunk, averages_blocks_and_leaves_no_data_out) {
  geometry::Grid<float> grid({0.0, 3.0, 1.0, 3, 3}, 1.0F);
  grid.at(0, 0) = 5.0F;
  grid.at(0, 1) = kNan;
  const auto mean = shrunk(grid, 2, Merge::mean);
  ASSERT_EQ(mean.geometry.columns, 2U);
  EXPECT_DOUBLE_EQ(mean.geometry.cell, 2.0);
  EXPECT_FLOAT_EQ(mean.at(0, 0), (5.0F + 1.0F + 1.0F) / 3.0F);
  EXPECT_FLOAT_EQ(shrunk(grid, 2, Merge::maximum).at(0, 0), 5.0F);
  EXPECT_EQ(shrunk(grid, 3, Merge::mean).values.size(), 9U);
}

TEST(ViewCounts, nothing_seen_stands_out_and_many_are_capped) {
  geometry::Grid<float> grid({0.0, 1.0, 1.0, 4, 1}, 0.0F);
  grid.values = {0.0F, 1.0F, 40.0F, kNan};
  const IndexedImage image = view_counts(grid, 9);
  EXPECT_EQ(image.palette[image.pixels[0]], (Rgba{213, 94, 0, 255}));
  EXPECT_EQ(image.palette[image.pixels[1]], cividis(0.0));
  EXPECT_EQ(image.palette[image.pixels[2]], cividis(1.0));
  EXPECT_EQ(image.palette[image.pixels[3]][3], 0);
}

TEST(CostPicture, free_is_clear_and_lethal_is_dark) {
  geometry::Grid<float> grid({0.0, 1.0, 1.0, 4, 1}, 0.0F);
  grid.values = {0.0F, 120.0F, 254.0F, kNan};
  const IndexedImage image = cost_picture(grid, 252.0, 253.0);
  EXPECT_EQ(image.palette[image.pixels[0]][3], 0);
  EXPECT_EQ(image.palette[image.pixels[1]][3], 255);
  EXPECT_EQ(image.palette[image.pixels[2]], (Rgba{38, 12, 56, 255}));
  EXPECT_EQ(image.palette[image.pixels[3]][3], 0);
}

TEST(Packed, whole_numbers_stay_exact_and_heights_keep_a_millimetre) {
  geometry::Grid<float> counts({0.0, 1.0, 1.0, 3, 1}, 0.0F);
  counts.values = {2.0F, 9.0F, kNan};
  const PackedGrid c = packed(counts, 10, Merge::mean);
  EXPECT_DOUBLE_EQ(c.step, 1.0);
  EXPECT_DOUBLE_EQ(c.offset, 2.0);
  geometry::Grid<float> heights({0.0, 1.0, 1.0, 2, 1}, 0.0F);
  heights.values = {1.25F, 31.5F};
  EXPECT_DOUBLE_EQ(packed(heights, 10, Merge::mean).step, 0.001);
}

// Lightness of the ramps for values must rise or fall evenly, or patterns appear that the data do not have.
TEST(Palette, ramps_are_monotone_in_lightness) {
  const auto luma = [](const Rgba& c) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; };
  for (int i = 1; i <= 50; ++i) {
    EXPECT_GT(luma(cividis(i / 50.0)), luma(cividis((i - 1) / 50.0)));
    EXPECT_LT(luma(cost_ramp(i / 50.0)), luma(cost_ramp((i - 1) / 50.0)));
    EXPECT_GT(luma(height_ramp(i / 50.0)), luma(height_ramp((i - 1) / 50.0)));
  }
}

}  // namespace
}  // namespace cairn::report
