#include "io/raster.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <thread>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "geodesy/crs.hpp"
#include "support/command.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using geometry::Grid;
using geometry::GridGeometry;
using geometry::Vec3;
using ::testing::HasSubstr;
using ::testing::Not;

const geodesy::LocalFrame kFrame({46.842979, -91.993612, 198.0});

std::vector<RasterBand> heights(std::size_t columns, std::size_t rows) {
  Grid<float> z({-120.0, 80.5, 0.25, columns, rows}, 0.0F);
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t c = 0; c < columns; ++c)
      z.at(r, c) = (r + c) % 17 == 0 ? std::numeric_limits<float>::quiet_NaN()
                                     : 183.0F + std::sin(static_cast<float>(c) / 30.0F) + static_cast<float>(r) * 0.01F;
  Grid<float> sigma(z.geometry, 0.05F);
  return {{"height", "m", "Height of the surface above the WGS84 ellipsoid", z, std::nullopt},
          {"sigma", "m", "1 sigma", sigma, std::nullopt}};
}

std::vector<RasterBand> cost() {
  Grid<std::uint8_t> g({0.0, 10.0, 0.1, 700, 100}, 0);
  for (std::size_t i = 0; i < g.values.size(); ++i) g.values[i] = static_cast<std::uint8_t>(i % 256);
  return {{"cost", "", "Traversal cost 0..100; 255 not known", g, 255}};
}

std::string error_of(base::ErrorCode code, const std::function<void()>& act) {
  try {
    act();
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  return "no error";
}

TEST(Raster, RoundTripFloat) {
  const testing::TempFolder folder;
  const auto bands = heights(1300, 900);
  write_cog(folder / "surface.tif", bands, kFrame.raster_crs_wkt());
  const Raster read = read_raster(folder / "surface.tif");
  ASSERT_EQ(read.bands.size(), 2U);
  for (std::size_t b = 0; b < 2; ++b) {
    EXPECT_EQ(read.bands[b].name, bands[b].name);
    EXPECT_EQ(read.bands[b].unit, bands[b].unit);
    EXPECT_EQ(read.bands[b].description, bands[b].description);
    EXPECT_EQ(read.bands[b].geometry(), bands[b].geometry());
    const auto& expected = std::get<Grid<float>>(bands[b].values).values;
    const auto& found = std::get<Grid<float>>(read.bands[b].values).values;
    ASSERT_EQ(found.size(), expected.size());
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < found.size(); ++i)
      if (std::isnan(expected[i]) ? !std::isnan(found[i]) : found[i] != expected[i]) ++wrong;
    EXPECT_EQ(wrong, 0U);
  }
}

TEST(Raster, RoundTripIntegers) {
  const testing::TempFolder folder;
  write_cog(folder / "cost.tif", cost(), "EPSG:32615");
  const Raster read = read_raster(folder / "cost.tif");
  EXPECT_EQ(read.bands[0].nodata, 255);
  EXPECT_EQ(std::get<Grid<std::uint8_t>>(read.bands[0].values).values,
            std::get<Grid<std::uint8_t>>(cost()[0].values).values);
  EXPECT_EQ(geodesy::describe_crs(read.crs).authority_code, "EPSG:32615");

  Grid<std::int32_t> ids({0.0, 1.0, 1.0, 2, 1}, -32768);
  ids.at(0, 1) = 70000;
  write_cog(folder / "ids.tif", {{"id", "", "", ids, -32768}}, "EPSG:32615");
  const Raster id = read_raster(folder / "ids.tif");
  EXPECT_EQ(id.bands[0].nodata, -32768);
  EXPECT_EQ(std::get<Grid<std::int32_t>>(id.bands[0].values).values, ids.values);
}

TEST(Raster, SameBytesEveryTime) {
  const testing::TempFolder folder;
  const auto bands = heights(1300, 900);
  write_cog(folder / "a.tif", bands, kFrame.raster_crs_wkt());
  std::vector<std::thread> threads;
  for (const char* name : {"b.tif", "c.tif"})
    threads.emplace_back([&, name] { write_cog(folder / name, bands, kFrame.raster_crs_wkt()); });
  for (auto& thread : threads) thread.join();
  const std::string a = base::read_file(folder / "a.tif");
  EXPECT_EQ(a, base::read_file(folder / "b.tif"));
  EXPECT_EQ(a, base::read_file(folder / "c.tif"));
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
    files += entry.is_regular_file() ? 1U : 0U;
  EXPECT_EQ(files, 3U) << "sidecar files";
}

TEST(Raster, GdalinfoAgreesWithoutWarning) {
  const testing::TempFolder folder;
  write_cog(folder / "surface.tif", heights(1300, 900), kFrame.raster_crs_wkt());
  const auto info = testing::run_command("gdalinfo " + (folder / "surface.tif").string());
  EXPECT_EQ(info.exit_code, 0);
  EXPECT_THAT(info.text, Not(HasSubstr("Warning")));
  EXPECT_THAT(info.text, Not(HasSubstr("ERROR")));
  for (const char* expected :
       {"LAYOUT=COG", "Block=512x512", "COMPRESSION=DEFLATE", "PREDICTOR=3", "NoData Value=nan", "AREA_OR_POINT=Area",
        "Description = height", "Unit Type: m", "Overviews: 650x450", "Transverse Mercator", "Size is 1300, 900",
        "Origin = (-120.0", "definition=Height of the surface above the WGS84 ellipsoid"})
    EXPECT_THAT(info.text, HasSubstr(expected));
  write_cog(folder / "cost.tif", cost(), kFrame.raster_crs_wkt());
  const auto byte = testing::run_command("gdalinfo " + (folder / "cost.tif").string());
  EXPECT_THAT(byte.text, Not(HasSubstr("Warning")));
  for (const char* expected : {"Type=Byte", "NoData Value=255", "PREDICTOR=2", "Overviews: 350x50"})
    EXPECT_THAT(byte.text, HasSubstr(expected));
}

// The file's CRS, as a stranger reads it, puts a cell where the local frame says it is.
TEST(Raster, LinesUpWithTheLocalFrame) {
  constexpr double kToleranceM = 1e-3;  // design, section 3
  const testing::TempFolder folder;
  write_cog(folder / "surface.tif", heights(1300, 900), kFrame.raster_crs_wkt());
  const Raster read = read_raster(folder / "surface.tif");
  const geodesy::CrsConverter crs(read.crs, kFrame);
  const auto corner = read.bands[0].geometry().centre(899, 1299);
  const Vec3 local(corner.x(), corner.y(), 0.0);
  const Vec3 outside = crs.from_local(local);
  EXPECT_NEAR(outside.x(), local.x(), kToleranceM);
  EXPECT_NEAR(outside.y(), local.y(), kToleranceM);
}

TEST(Raster, RefusesWhatItCannotWrite) {
  const testing::TempFolder folder;
  auto bands = heights(4, 4);
  std::get<Grid<float>>(bands[1].values).values[3] = std::numeric_limits<float>::infinity();
  EXPECT_THAT(error_of(base::ErrorCode::invalid_argument, [&] { write_cog(folder / "a.tif", bands, "EPSG:32615"); }),
              HasSubstr("infinite"));
  bands = heights(4, 4);
  bands[1].values = Grid<float>({0.0, 0.0, 1.0, 4, 4}, 0.0F);
  EXPECT_THAT(error_of(base::ErrorCode::invalid_argument, [&] { write_cog(folder / "a.tif", bands, "EPSG:32615"); }),
              HasSubstr("geometry"));
  bands[1].values = Grid<std::uint8_t>(heights(4, 4)[0].geometry(), 0);
  EXPECT_THAT(error_of(base::ErrorCode::invalid_argument, [&] { write_cog(folder / "a.tif", bands, "EPSG:32615"); }),
              HasSubstr("value type"));
  EXPECT_NE(error_of(base::ErrorCode::crs_mismatch, [&] { write_cog(folder / "a.tif", heights(4, 4), "nonsense"); }),
            "no error");
  EXPECT_NE(error_of(base::ErrorCode::resource_exhausted,
                     [&] { write_cog(folder / "absent/a.tif", heights(4, 4), "EPSG:32615"); }),
            "no error");
  EXPECT_NE(error_of(base::ErrorCode::resource_exhausted, [] { write_cog("/dev/full", heights(4, 4), "EPSG:32615"); }),
            "no error");
  EXPECT_FALSE(std::filesystem::exists(folder / "a.tif"));
}

TEST(Raster, RefusesWhatItCannotRead) {
  const testing::TempFolder folder;
  EXPECT_NE(error_of(base::ErrorCode::not_found, [&] { (void)read_raster(folder / "absent.tif"); }), "no error");
  EXPECT_NE(error_of(base::ErrorCode::not_found, [&] { (void)read_raster("/vsicurl/http://example.org/a.tif"); }),
            "no error");
  // A VRT is no GeoTIFF, whatever it is called.
  base::write_file(folder / "trap.tif",
                   "<VRTDataset rasterXSize=\"1\" rasterYSize=\"1\"><VRTRasterBand dataType=\"Byte\" band=\"1\"/>"
                   "</VRTDataset>");
  EXPECT_NE(error_of(base::ErrorCode::invalid_input, [&] { (void)read_raster(folder / "trap.tif"); }), "no error");

  write_cog(folder / "good.tif", heights(1300, 900), "EPSG:32615");
  const std::string good = base::read_file(folder / "good.tif");
  base::write_file(folder / "short.tif", good.substr(0, good.size() / 2));
  EXPECT_THAT(error_of(base::ErrorCode::invalid_input, [&] { (void)read_raster(folder / "short.tif"); }),
              HasSubstr("short.tif"));

  // GDAL's own tools make the odd ones.
  const std::string base_command = "gdal_translate -q " + (folder / "good.tif").string() + " ";
  ASSERT_EQ(testing::run_command(base_command + "-a_ullr 0 10 10 0 " + (folder / "stretched.tif").string()).exit_code,
            0);
  EXPECT_THAT(error_of(base::ErrorCode::invalid_input, [&] { (void)read_raster(folder / "stretched.tif"); }),
              HasSubstr("square"));
  ASSERT_EQ(testing::run_command(base_command + "-a_ullr 0 0 1300 900 " + (folder / "south.tif").string()).exit_code,
            0);
  EXPECT_THAT(error_of(base::ErrorCode::invalid_input, [&] { (void)read_raster(folder / "south.tif"); }),
              HasSubstr("north-up"));
  base::write_file(
      folder / "rotated.vrt",
      "<VRTDataset rasterXSize=\"10\" rasterYSize=\"10\"><SRS>EPSG:32615</SRS><GeoTransform>500000, 0.9, 0.1, "
      "5000000, 0.1, -0.9</GeoTransform><VRTRasterBand dataType=\"Byte\" band=\"1\"/></VRTDataset>");
  ASSERT_EQ(testing::run_command("gdal_translate -q " + (folder / "rotated.vrt").string() + " " +
                                 (folder / "rotated.tif").string())
                .exit_code,
            0);
  EXPECT_THAT(error_of(base::ErrorCode::invalid_input, [&] { (void)read_raster(folder / "rotated.tif"); }),
              HasSubstr("rotated raster"));
  ASSERT_EQ(testing::run_command("gdal_create -q -ot Byte -outsize 4 4 " + (folder / "nowhere.tif").string()).exit_code,
            0);
  EXPECT_THAT(error_of(base::ErrorCode::invalid_input, [&] { (void)read_raster(folder / "nowhere.tif"); }),
              HasSubstr("without a place"));

  // A header that promises 40000 x 40000 cells in a few kilobytes.
  ASSERT_EQ(testing::run_command("gdal_create -q -of GTiff -ot Float32 -outsize 40000 40000 -co SPARSE_OK=TRUE -a_srs "
                                 "EPSG:32615 -a_ullr 0 40000 40000 0 " +
                                 (folder / "bomb.tif").string())
                .exit_code,
            0);
  EXPECT_THAT(error_of(base::ErrorCode::invalid_input, [&] { (void)read_raster(folder / "bomb.tif"); }),
              HasSubstr("40000 x 40000"));
  EXPECT_EQ(raster_info(folder / "bomb.tif").geometry.columns, 40000U);
  EXPECT_THAT(error_of(base::ErrorCode::invalid_input, [&] { (void)read_raster(folder / "good.tif", {1000}); }),
              HasSubstr("1000 bytes"));
}

TEST(Raster, ReadsOtherTypes) {
  const testing::TempFolder folder;
  write_cog(folder / "good.tif", cost(), "EPSG:32615");
  const std::string command = "gdal_translate -q " + (folder / "good.tif").string() + " ";
  ASSERT_EQ(testing::run_command(command + "-ot Int16 -a_nodata -9999 " + (folder / "i16.tif").string()).exit_code, 0);
  EXPECT_EQ(read_raster(folder / "i16.tif").bands[0].nodata, -9999);
  ASSERT_EQ(testing::run_command(command + "-ot Float64 -a_nodata 7 " + (folder / "f64.tif").string()).exit_code, 0);
  const Raster doubles = read_raster(folder / "f64.tif");
  const auto& grid = std::get<Grid<float>>(doubles.bands[0].values);
  EXPECT_TRUE(std::isnan(grid.values[7]));
  EXPECT_EQ(grid.values[8], 8.0F);
  ASSERT_EQ(testing::run_command(command + "-a_scale 0.5 -a_offset 100 " + (folder / "scaled.tif").string()).exit_code,
            0);
  EXPECT_EQ(std::get<Grid<float>>(read_raster(folder / "scaled.tif").bands[0].values).values[8], 104.0F);
}

}  // namespace
}  // namespace cairn::io
