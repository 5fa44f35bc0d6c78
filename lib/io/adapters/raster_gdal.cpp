#include "io/raster.hpp"

#include <cpl_string.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/adapters/gdal_session.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;
using geometry::GridGeometry;

struct CloseDataset {
  void operator()(GDALDataset* d) const { GDALClose(d); }
};
using Dataset = std::unique_ptr<GDALDataset, CloseDataset>;

constexpr const char* kDefinition = "definition";  // metadata item of a band

template <typename T>
constexpr GDALDataType kGdalType = GDT_Unknown;
template <>
constexpr GDALDataType kGdalType<float> = GDT_Float32;
template <>
constexpr GDALDataType kGdalType<std::uint8_t> = GDT_Byte;
template <>
constexpr GDALDataType kGdalType<std::int32_t> = GDT_Int32;

[[noreturn]] void refuse_bands(const std::filesystem::path& path, std::string message, const RasterBand& band) {
  throw Error(ErrorCode::invalid_argument, std::move(message)).file(path.string()).record("band '" + band.name + "'");
}

void check_bands(const std::filesystem::path& path, const std::vector<RasterBand>& bands) {
  if (bands.empty()) throw Error(ErrorCode::invalid_argument, "a raster without bands").file(path.string());
  const GridGeometry& geometry = bands.front().geometry();
  constexpr std::size_t kMaxEdge = std::numeric_limits<int>::max() / 2;
  if (geometry.cells() == 0 || geometry.columns > kMaxEdge || geometry.rows > kMaxEdge || !(geometry.cell > 0.0) ||
      !std::isfinite(geometry.cell) || !std::isfinite(geometry.west) || !std::isfinite(geometry.north))
    refuse_bands(path, "a raster without a usable size or place", bands.front());
  for (const auto& band : bands) {
    if (!(band.geometry() == geometry)) refuse_bands(path, "a band with another geometry than the first", band);
    if (band.values.index() != bands.front().values.index())
      refuse_bands(path, "a band with another value type than the first", band);
    if (band.nodata != bands.front().nodata) refuse_bands(path, "a band with another nodata than the first", band);
    std::visit(
        [&](const auto& grid) {
          using T = typename std::decay_t<decltype(grid.values)>::value_type;
          if (grid.values.size() != geometry.cells()) refuse_bands(path, "a band without a value for each cell", band);
          if constexpr (std::is_same_v<T, float>) {
            if (std::any_of(grid.values.begin(), grid.values.end(), [](float v) { return std::isinf(v); }))
              refuse_bands(path, "a band with an infinite value", band);
          } else if (band.nodata && (*band.nodata < static_cast<std::int64_t>(std::numeric_limits<T>::min()) ||
                                     *band.nodata > static_cast<std::int64_t>(std::numeric_limits<T>::max()))) {
            refuse_bands(path, "a nodata value that the band's type cannot hold", band);
          }
        },
        band.values);
  }
}

OGRSpatialReference spatial_reference(const std::string& crs, const GdalMessages& messages,
                                      const std::filesystem::path& path) {
  OGRSpatialReference srs;
  srs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  const bool known = crs.rfind("EPSG:", 0) == 0 ? srs.SetFromUserInput(crs.c_str()) == OGRERR_NONE
                                                : srs.importFromWkt(crs.c_str()) == OGRERR_NONE;
  if (!known) messages.raise(ErrorCode::crs_mismatch, "a raster's CRS that cannot be read", path);
  return srs;
}

// A dataset that borrows the bands' memory.
Dataset wrap(const std::vector<RasterBand>& bands, const std::string& crs, const GdalMessages& messages,
             const std::filesystem::path& path) {
  const GridGeometry& g = bands.front().geometry();
  GDALDriver* memory = GetGDALDriverManager()->GetDriverByName("MEM");
  Dataset dataset(memory->Create("", static_cast<int>(g.columns), static_cast<int>(g.rows), 0, GDT_Byte, nullptr));
  if (!dataset) messages.raise(ErrorCode::internal, "GDAL could not make a raster", path);
  double transform[6] = {g.west, g.cell, 0.0, g.north, 0.0, -g.cell};
  dataset->SetGeoTransform(transform);
  const OGRSpatialReference srs = spatial_reference(crs, messages, path);
  dataset->SetSpatialRef(&srs);
  dataset->SetMetadataItem(GDALMD_AREA_OR_POINT, GDALMD_AOP_AREA);
  for (const auto& band : bands)
    std::visit(
        [&](const auto& grid) {
          using T = typename std::decay_t<decltype(grid.values)>::value_type;
          char address[64] = {};
          CPLPrintPointer(address, const_cast<T*>(grid.values.data()), sizeof(address) - 1);
          CPLStringList options;
          options.SetNameValue("DATAPOINTER", address);
          if (dataset->AddBand(kGdalType<T>, options.List()) != CE_None)
            messages.raise(ErrorCode::internal, "GDAL refused a band", path);
          GDALRasterBand* out = dataset->GetRasterBand(dataset->GetRasterCount());
          out->SetDescription(band.name.c_str());
          if (!band.unit.empty()) out->SetUnitType(band.unit.c_str());
          if (!band.description.empty()) out->SetMetadataItem(kDefinition, band.description.c_str());
          if constexpr (std::is_same_v<T, float>) out->SetNoDataValue(std::numeric_limits<double>::quiet_NaN());
          else if (band.nodata) out->SetNoDataValue(*band.nodata);
        },
        band.values);
  return dataset;
}

std::string crs_of(const GDALDataset& dataset) {
  const OGRSpatialReference* srs = dataset.GetSpatialRef();
  if (srs == nullptr || srs->IsEmpty()) return "";
  char* wkt = nullptr;
  const char* const options[] = {"FORMAT=WKT2_2019", "MULTILINE=NO", nullptr};
  std::string text;
  if (srs->exportToWkt(&wkt, options) == OGRERR_NONE && wkt != nullptr) text = wkt;
  CPLFree(wkt);
  return text;
}

Dataset open_raster(const std::filesystem::path& path, GdalMessages& messages) {
  const char* const drivers[] = {"GTiff", nullptr};
  Dataset dataset(
      GDALDataset::Open(gdal_input_path(path).c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, drivers, nullptr, nullptr));
  if (!dataset || messages.failed()) messages.raise(ErrorCode::invalid_input, "not a readable GeoTIFF", path);
  return dataset;
}

GridGeometry geometry_of(GDALDataset& dataset, const std::filesystem::path& path) {
  double t[6] = {};
  if (dataset.GetGeoTransform(t) != CE_None)
    throw Error(ErrorCode::invalid_input, "a raster without a place (no geotransform)").file(path.string());
  constexpr double kSlack = 1e-9;  // relative: the edges of a cell as text differ in the last digits
  const auto refuse = [&](std::string message, std::string found) {
    throw Error(ErrorCode::invalid_input, std::move(message))
        .file(path.string())
        .found(found)
        .allowed("north-up with square cells")
        .hint("Resample it with gdalwarp first");
  };
  for (const double value : t)
    if (!std::isfinite(value)) refuse("a geotransform that is not finite", base::to_text(value));
  if (std::abs(t[2]) > kSlack * std::abs(t[1]) || std::abs(t[4]) > kSlack * std::abs(t[5]))
    refuse("a rotated raster", "row rotation " + base::to_text(t[2]) + ", column rotation " + base::to_text(t[4]));
  if (!(t[1] > 0.0) || !(t[5] < 0.0))
    refuse("a raster that is not north-up", "cell " + base::to_text(t[1]) + " by " + base::to_text(t[5]));
  if (std::abs(t[1] + t[5]) > 1e-6 * t[1])
    refuse("cells that are not square", base::to_text(t[1]) + " by " + base::to_text(-t[5]));
  return {t[0], t[3], t[1], static_cast<std::size_t>(dataset.GetRasterXSize()),
          static_cast<std::size_t>(dataset.GetRasterYSize())};
}

bool is_scaled(GDALRasterBand& band) {
  return band.GetScale() != 1.0 || band.GetOffset() != 0.0;
}

template <typename T>
geometry::Grid<T> read_values(GDALRasterBand& band, const GridGeometry& g, const GdalMessages& messages,
                              const std::filesystem::path& path) {
  geometry::Grid<T> grid(g, T{});
  if (band.RasterIO(GF_Read, 0, 0, static_cast<int>(g.columns), static_cast<int>(g.rows), grid.values.data(),
                    static_cast<int>(g.columns), static_cast<int>(g.rows), kGdalType<T>, 0, 0, nullptr) != CE_None ||
      messages.failed())
    messages.raise(ErrorCode::invalid_input, "a raster that cannot be decoded", path);
  return grid;
}

// Doubles are compared with nodata before they are narrowed, row by row.
geometry::Grid<float> read_floats(GDALRasterBand& band, const GridGeometry& g, const GdalMessages& messages,
                                  const std::filesystem::path& path) {
  geometry::Grid<float> grid(g, std::numeric_limits<float>::quiet_NaN());
  int has_nodata = 0;
  double nodata = band.GetNoDataValue(&has_nodata);
  if (has_nodata != 0 && band.GetRasterDataType() == GDT_Float32)
    nodata = static_cast<double>(static_cast<float>(nodata));
  const double scale = band.GetScale();
  const double offset = band.GetOffset();
  std::vector<double> row(g.columns);
  for (std::size_t r = 0; r < g.rows; ++r) {
    if (band.RasterIO(GF_Read, 0, static_cast<int>(r), static_cast<int>(g.columns), 1, row.data(),
                      static_cast<int>(g.columns), 1, GDT_Float64, 0, 0, nullptr) != CE_None ||
        messages.failed())
      messages.raise(ErrorCode::invalid_input, "a raster that cannot be decoded", path);
    for (std::size_t c = 0; c < g.columns; ++c) {
      if (has_nodata != 0 && row[c] == nodata) continue;
      const double value = row[c] * scale + offset;
      if (std::abs(value) <= static_cast<double>(std::numeric_limits<float>::max()))
        grid.at(r, c) = static_cast<float>(value);
    }
  }
  return grid;
}

// Bytes in memory of one cell of a band.
std::uint64_t cell_bytes(GDALRasterBand& band) {
  return band.GetRasterDataType() == GDT_Byte && !is_scaled(band) ? 1 : 4;
}

void check_size(GDALDataset& dataset, const GridGeometry& g, const RasterLimits& limits,
                const std::filesystem::path& path) {
  std::uint64_t per_cell = 0;
  for (int b = 1; b <= dataset.GetRasterCount(); ++b) per_cell += cell_bytes(*dataset.GetRasterBand(b));
  // Both edges fit an int, so the product of three fits 64 bits only when checked.
  const auto cells = static_cast<std::uint64_t>(g.columns) * static_cast<std::uint64_t>(g.rows);
  // DEFLATE reaches 1032:1; below the floor any ratio may pass (a constant raster).
  constexpr std::uint64_t kMaxRatio = 1100;
  constexpr std::uint64_t kFloor = std::uint64_t{64} << 20U;
  const std::uint64_t by_file = std::max<std::uint64_t>(kFloor, std::filesystem::file_size(path) * kMaxRatio);
  const std::uint64_t allowed = std::min(limits.bytes, by_file);
  if (per_cell == 0 || cells > allowed / per_cell)
    throw Error(ErrorCode::invalid_input, "a raster larger than its file or the limit can justify")
        .file(path.string())
        .found(std::to_string(g.columns) + " x " + std::to_string(g.rows) + " cells of " + std::to_string(per_cell) +
               " bytes")
        .allowed(std::to_string(allowed) + " bytes");
}

std::string item(GDALRasterBand& band, const char* key) {
  const char* value = band.GetMetadataItem(key);
  return value != nullptr ? value : "";
}

RasterBand read_band(GDALRasterBand& band, const GridGeometry& g, const GdalMessages& messages,
                     const std::filesystem::path& path) {
  RasterBand out;
  out.name = band.GetDescription();
  out.unit = band.GetUnitType();
  out.description = item(band, kDefinition);
  int has_nodata = 0;
  const double nodata = band.GetNoDataValue(&has_nodata);
  const auto keep_nodata = [&](double lo, double hi) {
    if (has_nodata != 0 && nodata >= lo && nodata <= hi && nodata == std::floor(nodata))
      out.nodata = static_cast<std::int32_t>(nodata);
  };
  const char* pixel_type = band.GetMetadataItem("PIXELTYPE", "IMAGE_STRUCTURE");
  const bool is_signed_byte = pixel_type != nullptr && EQUAL(pixel_type, "SIGNEDBYTE");
  const GDALDataType type = band.GetRasterDataType();
  if (GDALDataTypeIsComplex(type) != 0)
    throw Error(ErrorCode::invalid_input, "complex values").file(path.string()).allowed("real values");
  if (is_scaled(band) || type == GDT_Float32 || type == GDT_Float64 || type == GDT_UInt32 || type == GDT_Int64 ||
      type == GDT_UInt64) {
    out.values = read_floats(band, g, messages, path);
  } else if (type == GDT_Byte && !is_signed_byte) {
    keep_nodata(0.0, 255.0);
    out.values = read_values<std::uint8_t>(band, g, messages, path);
  } else if (is_signed_byte) {
    auto grid = read_values<std::int32_t>(band, g, messages, path);
    for (auto& value : grid.values) value = value > 127 ? value - 256 : value;
    keep_nodata(-128.0, 127.0);
    out.values = std::move(grid);
  } else {
    keep_nodata(std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max());
    out.values = read_values<std::int32_t>(band, g, messages, path);
  }
  return out;
}

}  // namespace

const GridGeometry& RasterBand::geometry() const {
  return std::visit([](const auto& grid) -> const GridGeometry& { return grid.geometry; }, values);
}

void write_cog(const std::filesystem::path& path, const std::vector<RasterBand>& bands, const std::string& crs) {
  check_bands(path, bands);
  start_gdal();
  GdalMessages messages;
  const Dataset source = wrap(bands, crs, messages, path);
  const bool is_float = std::holds_alternative<geometry::Grid<float>>(bands.front().values);
  CPLStringList options;
  options.SetNameValue("BLOCKSIZE", "512");
  options.SetNameValue("COMPRESS", "DEFLATE");
  options.SetNameValue("LEVEL", "6");
  options.SetNameValue("PREDICTOR", "YES");
  options.SetNameValue("OVERVIEWS", "AUTO");
  options.SetNameValue("OVERVIEW_RESAMPLING", is_float ? "AVERAGE" : "NEAREST");
  options.SetNameValue("BIGTIFF", "IF_SAFER");
  options.SetNameValue("NUM_THREADS", "1");
  const MemoryFile file(".tif");
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("COG");
  Dataset written(driver->CreateCopy(file.path().c_str(), source.get(), FALSE, options.List(), nullptr, nullptr));
  if (!written) messages.raise(ErrorCode::resource_exhausted, "the raster could not be made", path);
  written.reset();
  const std::string_view bytes = file.bytes();
  if (messages.failed() || bytes.empty())
    messages.raise(ErrorCode::resource_exhausted, "the raster could not be made", path);
  base::write_file(path, bytes);
}

Raster read_raster(const std::filesystem::path& path, const RasterLimits& limits) {
  start_gdal();
  GdalMessages messages;
  const Dataset dataset = open_raster(path, messages);
  if (dataset->GetRasterCount() == 0)
    throw Error(ErrorCode::invalid_input, "a raster without bands").file(path.string());
  const GridGeometry g = geometry_of(*dataset, path);
  check_size(*dataset, g, limits, path);
  Raster raster;
  raster.crs = crs_of(*dataset);
  for (int b = 1; b <= dataset->GetRasterCount(); ++b)
    raster.bands.push_back(read_band(*dataset->GetRasterBand(b), g, messages, path));
  return raster;
}

RasterInfo raster_info(const std::filesystem::path& path) {
  start_gdal();
  GdalMessages messages;
  const Dataset dataset = open_raster(path, messages);
  RasterInfo info;
  info.crs = crs_of(*dataset);
  info.geometry = geometry_of(*dataset, path);
  for (int b = 1; b <= dataset->GetRasterCount(); ++b) {
    GDALRasterBand& band = *dataset->GetRasterBand(b);
    info.bands.push_back({band.GetDescription(), band.GetUnitType(), item(band, kDefinition),
                          GDALGetDataTypeName(band.GetRasterDataType())});
  }
  return info;
}

}  // namespace cairn::io
