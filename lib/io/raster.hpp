// Rasters as plain data; Cloud-Optimised GeoTIFF out, GeoTIFF in.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "geometry/grid.hpp"

namespace cairn::io {

using RasterValues = std::variant<geometry::Grid<float>, geometry::Grid<std::uint8_t>, geometry::Grid<std::int32_t>>;

struct RasterBand {
  std::string name;         // "height", the band's description in GDAL's words
  std::string unit;         // "m", "deg", "" for none
  std::string description;  // one sentence; heights name their datum here
  RasterValues values;
  // Value that means "not known". Floats: always NaN, whatever stands here. Integers: none when empty;
  // 255 is the custom for cost layers.
  std::optional<std::int32_t> nodata;

  [[nodiscard]] const geometry::GridGeometry& geometry() const;
};

// Cloud-Optimised GeoTIFF: blocks of 512, overviews (average for floats, nearest for integers), DEFLATE
// with predictor, AREA_OR_POINT=Area, band names, units and descriptions. All bands share one value
// type, geometry and nodata; else invalid_argument, as with an infinite value.
// crs: WKT or "EPSG:n" of the grid's coordinates (LocalFrame::raster_crs_wkt() for local grids).
// The same input gives the same bytes on any number of threads. Built in memory, then written at once.
// Throws resource_exhausted where it cannot be written.
void write_cog(const std::filesystem::path& path, const std::vector<RasterBand>& bands, const std::string& crs);

struct Raster {
  std::string crs;  // WKT2, "" where the file declares none
  std::vector<RasterBand> bands;
};

struct RasterLimits {
  std::uint64_t bytes = std::uint64_t{4} << 30U;  // of all bands in memory
};

// GeoTIFF (COG or not), north-up with square cells; a rotated, south-up or stretched one is
// invalid_input. The grid's coordinates are those of the file's CRS, in its unit. 16-bit and 8-bit
// signed integers become int32; 32-bit unsigned integers, doubles and scaled bands become float (NaN
// where nodata). Nothing but the file itself is opened.
// The header's size is checked against limits and the file's size before memory is reserved.
[[nodiscard]] Raster read_raster(const std::filesystem::path& path, const RasterLimits& limits = {});

struct RasterInfo {
  std::string crs;
  geometry::GridGeometry geometry;
  struct Band {
    std::string name, unit, description, type;  // type in GDAL's words: "Float32"
  };
  std::vector<Band> bands;
};
// Header only; the same refusals but for the size.
[[nodiscard]] RasterInfo raster_info(const std::filesystem::path& path);

}  // namespace cairn::io
