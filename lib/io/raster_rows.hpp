// Rasters larger than memory: some rows at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/grid.hpp"
#include "io/raster.hpp"

namespace cairn::io {

// A GeoTIFF opened for reading by rows; the refusals of read_raster() but for the limit on memory.
class RasterRows {
 public:
  explicit RasterRows(const std::filesystem::path& path);
  ~RasterRows();
  RasterRows(const RasterRows&) = delete;
  RasterRows& operator=(const RasterRows&) = delete;

  [[nodiscard]] const RasterInfo& info() const;
  // Whether a band holds plain bytes.
  [[nodiscard]] bool is_byte(std::size_t band) const;
  [[nodiscard]] std::optional<double> nodata(std::size_t band) const;

  // rows * columns values of `rows` rows from first_row on. Throws invalid_input where they cannot be decoded.
  void read(std::size_t band, std::size_t first_row, std::size_t rows, std::span<std::uint8_t> values) const;
  // Any type of band: scaled values, NaN where nodata.
  void read(std::size_t band, std::size_t first_row, std::size_t rows, std::span<double> values) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

struct ByteBand {
  std::string name, unit, description;
};

// Tiled GeoTIFF of bytes, written from the north: blocks of 512, band after band in each row of blocks, fast
// DEFLATE, BigTIFF from 4 GB on, no overviews. The same values give the same bytes, however many rows come at once.
class RasterWriter {
 public:
  // crs: as write_cog(). Throws invalid_argument for a size without cells, resource_exhausted where it cannot be made.
  RasterWriter(const std::filesystem::path& path, const geometry::GridGeometry& geometry,
               const std::vector<ByteBand>& bands, std::uint8_t nodata, const std::string& crs);
  ~RasterWriter();
  RasterWriter(const RasterWriter&) = delete;
  RasterWriter& operator=(const RasterWriter&) = delete;

  // The same rows of every band: bands[b] holds rows * columns values.
  void rows(std::size_t rows, std::span<const std::uint8_t* const> bands);
  // Must be called: writes what is left and closes. Throws resource_exhausted where a write failed.
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn::io
