// GeoPackage out; GeoPackage, GeoJSON and Shapefile in.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "base/reject.hpp"
#include "io/vector_layer.hpp"

namespace cairn::io {

// One GeoPackage 1.2 with the layers in order: EPSG:4326 (heights in the coordinates' z and, with their
// datum, in columns), R-tree index, feature ids 1..n in record order; tables `layer_styles` (QGIS takes
// its style from it) and `cairn_columns` (layer, name, type, unit, definition). Time stamps are pinned:
// the same layers give the same bytes. journal_mode DELETE; no -wal or -shm file.
// The file is built in memory and written at once. Throws resource_exhausted where it cannot be written.
void write_geopackage(const std::filesystem::path& path, const std::vector<Layer>& layers);

// A layer as its file has it.
struct ForeignLayer {
  std::string name;
  std::string crs;  // WKT2, or "" where the file declares none; coordinates are x = easting or longitude
  GeometryKind kind = GeometryKind::none;  // of the first feature that has a geometry
  std::vector<Column> columns;
  std::vector<BasicFeature<geometry::Vec3>> features;  // z = 0 where the file has none
  std::vector<base::Reject> rejects;                   // other geometry kinds, coordinates that are not finite
  std::size_t feature_count = 0;                       // in the file
};

struct VectorLimits {
  std::size_t features = 5'000'000;   // of all layers
  std::size_t vertices = 50'000'000;  // of all layers
};

// By content: .gpkg, .geojson/.json, .shp. Curves are refused as rejects. Never changes the file nor
// leaves anything beside it. Throws not_found, or invalid_input with GDAL's own words.
[[nodiscard]] std::vector<ForeignLayer> read_vector(const std::filesystem::path& path, const VectorLimits& limits = {});
// The same without the features: names, kinds, columns and counts.
[[nodiscard]] std::vector<ForeignLayer> vector_info(const std::filesystem::path& path);

}  // namespace cairn::io
