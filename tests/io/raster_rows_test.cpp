#include "io/raster_rows.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/random.hpp"
#include "geodesy/local_frame.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using geometry::Grid;
const std::string kCrs = geodesy::LocalFrame({46.84, -91.99, 198.0}).raster_crs_wkt();
const geometry::GridGeometry kShape{-3.0, 70.0, 0.05, 700, 1300};

std::vector<Grid<std::uint8_t>> random_bands() {
  base::Random random(1, "rows", 0);
  std::vector<Grid<std::uint8_t>> bands(2, Grid<std::uint8_t>(kShape, 0));
  for (auto& band : bands)
    for (std::size_t i = 0; i < band.values.size(); ++i)
      band.values[i] = i % 700 < 300 ? static_cast<std::uint8_t>(random.below(256)) : std::uint8_t{255};
  return bands;
}

void write(const std::filesystem::path& path, const std::vector<Grid<std::uint8_t>>& bands, std::size_t at_once) {
  RasterWriter writer(path, kShape, {{"cost", "", "cost of driving"}, {"occupancy", "", ""}}, 255, kCrs);
  for (std::size_t first = 0; first < kShape.rows; first += at_once) {
    const std::uint8_t* const rows[] = {&bands[0].values[first * 700], &bands[1].values[first * 700]};
    writer.rows(std::min(at_once, kShape.rows - first), rows);
  }
  writer.finish();
}

TEST(RasterWriter, SameBytesHoweverManyRowsComeAtOnce) {
  const testing::TempFolder folder;
  const auto bands = random_bands();
  write(folder / "whole.tif", bands, kShape.rows);
  const std::string whole = base::read_file(folder / "whole.tif");
  for (const std::size_t at_once : {1U, 100U, 512U, 600U}) {
    write(folder / "rows.tif", bands, at_once);
    EXPECT_EQ(base::read_file(folder / "rows.tif"), whole) << at_once;
  }
  const Raster read = read_raster(folder / "whole.tif");
  ASSERT_EQ(read.bands.size(), 2U);
  EXPECT_EQ(read.bands[0].name, "cost");
  EXPECT_EQ(read.bands[0].description, "cost of driving");
  EXPECT_EQ(read.bands[0].nodata, 255);
  EXPECT_EQ(read.bands[0].geometry(), kShape);
  for (std::size_t b = 0; b < 2; ++b)
    EXPECT_EQ(std::get<Grid<std::uint8_t>>(read.bands[b].values).values, bands[b].values);
}

TEST(RasterRows, ReadTheSameAsTheWhole) {
  const testing::TempFolder folder;
  const auto bands = random_bands();
  write_cog(folder / "a.tif", {{"x", "", "", bands[0], 255}}, kCrs);
  const RasterRows rows(folder / "a.tif");
  EXPECT_TRUE(rows.is_byte(0));
  EXPECT_EQ(rows.nodata(0), 255.0);
  EXPECT_EQ(rows.info().geometry, kShape);
  std::vector<std::uint8_t> part(700 * 200);
  rows.read(0, 411, 200, std::span(part));
  EXPECT_TRUE(std::equal(part.begin(), part.end(), bands[0].values.begin() + 411 * 700));
  std::vector<double> reals(700);
  rows.read(0, 1299, 1, std::span(reals));
  for (std::size_t c = 0; c < 700; ++c) {
    const std::uint8_t value = bands[0].at(1299, c);
    EXPECT_TRUE(value == 255 ? std::isnan(reals[c]) : reals[c] == value) << c;
  }
  EXPECT_THROW(rows.read(0, 1200, 200, std::span(part)), base::Error);
}

TEST(RasterRows, RefusesOtherFiles) {
  const testing::TempFolder folder;
  base::write_file(folder / "a.tif", "II*\0nothing");
  EXPECT_THROW(RasterRows(folder / "a.tif"), base::Error);
  EXPECT_THROW(RasterRows(folder / "none.tif"), base::Error);
  EXPECT_THROW(RasterWriter(folder / "b.tif", {0, 0, 0.0, 1, 1}, {{"x", "", ""}}, 255, kCrs), base::Error);
  EXPECT_THROW(RasterWriter(folder / "b.tif", {0, 0, 1.0, 1, 1}, {{"x", "", ""}}, 255, "EPSG:0"), base::Error);
}

}  // namespace
}  // namespace cairn::io
