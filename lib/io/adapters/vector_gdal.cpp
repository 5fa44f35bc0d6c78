#include <cpl_string.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>
#include <ogrsf_frmts.h>

#include <cmath>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "base/error.hpp"
#include "io/adapters/gdal_session.hpp"
#include "io/vector.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Vec3;
using ForeignFeature = BasicFeature<Vec3>;
using Rings = std::vector<std::vector<Vec3>>;

struct CloseDataset {
  void operator()(GDALDataset* d) const { GDALClose(d); }
};
using Dataset = std::unique_ptr<GDALDataset, CloseDataset>;

bool is_sqlite(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string head(15, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  return head == "SQLite format 3";
}

Dataset open_vector(const std::filesystem::path& path, const GdalMessages& messages) {
  const std::string name = gdal_input_path(path);
  CPLStringList options;
  if (is_sqlite(path)) {
    std::error_code ignored;
    if (std::filesystem::file_size(path.string() + "-wal", ignored) > 0 && !ignored)
      throw Error(ErrorCode::invalid_input, "a GeoPackage that another program has not finished writing")
          .file(path.string())
          .found(path.filename().string() + "-wal beside it")
          .hint("Close it in that program (QGIS: remove the layer), then try again");
    // Neither locks nor -shm files, and the bytes stay as they are.
    options.SetNameValue("IMMUTABLE", "YES");
  }
  const char* const drivers[] = {"GPKG", "GeoJSON", "ESRI Shapefile", nullptr};
  Dataset dataset(GDALDataset::Open(name.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, drivers, options.List(), nullptr));
  if (!dataset || messages.failed())
    messages.raise(ErrorCode::invalid_input, "not a readable GeoPackage, GeoJSON or Shapefile", path);
  return dataset;
}

std::string crs_of(OGRLayer& layer) {
  const OGRSpatialReference* srs = layer.GetSpatialRef();
  if (srs == nullptr || srs->IsEmpty() || srs->IsLocal() != 0) return "";
  char* wkt = nullptr;
  const char* const options[] = {"FORMAT=WKT2_2019", "MULTILINE=NO", nullptr};
  std::string text;
  if (srs->exportToWkt(&wkt, options) == OGRERR_NONE && wkt != nullptr) text = wkt;
  CPLFree(wkt);
  return text;
}

GeometryKind kind_of(OGRwkbGeometryType type) {
  switch (wkbFlatten(type)) {
    case wkbPoint:
    case wkbMultiPoint: return GeometryKind::point;
    case wkbLineString:
    case wkbMultiLineString: return GeometryKind::line;
    case wkbPolygon:
    case wkbMultiPolygon: return GeometryKind::polygon;
    default: return GeometryKind::none;
  }
}

ColumnType column_type(const OGRFieldDefn& field) {
  switch (field.GetType()) {
    case OFTInteger: return field.GetSubType() == OFSTBoolean ? ColumnType::boolean : ColumnType::integer;
    case OFTInteger64: return ColumnType::integer;
    case OFTReal: return ColumnType::real;
    default: return ColumnType::text;
  }
}

Value value_of(OGRFeature& feature, int index, ColumnType type) {
  if (feature.IsFieldSetAndNotNull(index) == 0) return {};
  switch (type) {
    case ColumnType::boolean: return feature.GetFieldAsInteger(index) != 0;
    case ColumnType::integer: return static_cast<std::int64_t>(feature.GetFieldAsInteger64(index));
    case ColumnType::real: {
      const double value = feature.GetFieldAsDouble(index);
      return std::isfinite(value) ? Value(value) : Value();
    }
    case ColumnType::text: return std::string(feature.GetFieldAsString(index));
  }
  return {};
}

std::vector<Vec3> points_of(const OGRSimpleCurve& curve, bool is_ring) {
  std::vector<Vec3> points;
  const int count = curve.getNumPoints();
  points.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) points.emplace_back(curve.getX(i), curve.getY(i), curve.getZ(i));
  if (is_ring && points.size() > 1 && points.front().head<2>() == points.back().head<2>()) points.pop_back();
  return points;
}

// The parts of a simple geometry of `kind`; empty where it is of another.
std::vector<Rings> parts_of(const OGRGeometry& geometry) {
  std::vector<Rings> parts;
  switch (wkbFlatten(geometry.getGeometryType())) {
    case wkbPoint: {
      const OGRPoint& p = *geometry.toPoint();
      if (p.IsEmpty() == 0) parts.push_back({{Vec3(p.getX(), p.getY(), p.Is3D() != 0 ? p.getZ() : 0.0)}});
      break;
    }
    case wkbLineString: {
      auto points = points_of(*geometry.toLineString(), false);
      if (points.size() >= 2) parts.push_back({std::move(points)});
      break;
    }
    case wkbPolygon: {
      Rings rings;
      for (const OGRLinearRing* ring : *geometry.toPolygon()) {
        auto points = points_of(*ring, true);
        if (points.size() >= 3) rings.push_back(std::move(points));
        else if (rings.empty()) break;  // a polygon without a usable outer ring
      }
      if (!rings.empty()) parts.push_back(std::move(rings));
      break;
    }
    case wkbMultiPoint:
    case wkbMultiLineString:
    case wkbMultiPolygon:
      for (const OGRGeometry* member : *geometry.toGeometryCollection())
        for (auto& part : parts_of(*member)) parts.push_back(std::move(part));
      break;
    default: break;
  }
  return parts;
}

std::size_t vertices_of(const std::vector<Rings>& parts, bool& finite) {
  std::size_t count = 0;
  for (const auto& rings : parts)
    for (const auto& ring : rings) {
      count += ring.size();
      for (const auto& p : ring) finite = finite && p.allFinite();
    }
  return count;
}

struct Budget {
  std::size_t features, vertices;
  const std::filesystem::path& path;

  void take(std::size_t vertex_count) {
    if (features == 0 || vertex_count > vertices)
      throw Error(ErrorCode::invalid_input, "more features or vertices than the limit allows").file(path.string());
    --features;
    vertices -= vertex_count;
  }
};

ForeignLayer describe(OGRLayer& in) {
  ForeignLayer layer;
  layer.name = in.GetName();
  layer.crs = crs_of(in);
  layer.kind = kind_of(in.GetGeomType());
  const OGRFeatureDefn& definition = *in.GetLayerDefn();
  for (int c = 0; c < definition.GetFieldCount(); ++c) {
    const OGRFieldDefn& field = *definition.GetFieldDefn(c);
    layer.columns.push_back({field.GetNameRef(), column_type(field), "", ""});
  }
  const GIntBig count = in.GetFeatureCount();
  layer.feature_count = count > 0 ? static_cast<std::size_t>(count) : 0;
  return layer;
}

void read_features(OGRLayer& in, ForeignLayer& layer, Budget& budget) {
  in.ResetReading();
  layer.feature_count = 0;
  while (const std::unique_ptr<OGRFeature> row{in.GetNextFeature()}) {
    ++layer.feature_count;
    const std::string record = "feature " + std::to_string(row->GetFID());
    ForeignFeature feature;
    if (const OGRGeometry* geometry = row->GetGeometryRef(); geometry != nullptr && geometry->IsEmpty() == 0) {
      const GeometryKind kind = kind_of(geometry->getGeometryType());
      if (layer.kind == GeometryKind::none) layer.kind = kind;
      if (kind == GeometryKind::none || kind != layer.kind) {
        layer.rejects.push_back(
            {record, "other_geometry_kind",
             std::string(geometry->getGeometryName()) + " in a layer of kind " + std::string(name_of(layer.kind))});
        continue;
      }
      feature.parts = parts_of(*geometry);
      bool finite = true;
      budget.take(vertices_of(feature.parts, finite));
      if (!finite || feature.parts.empty()) {
        layer.rejects.push_back({record, finite ? "degenerate_geometry" : "not_finite",
                                 finite ? "too few vertices" : "a coordinate is not a finite number"});
        continue;
      }
    } else {
      budget.take(0);
    }
    for (std::size_t c = 0; c < layer.columns.size(); ++c)
      feature.values.push_back(value_of(*row, static_cast<int>(c), layer.columns[c].type));
    layer.features.push_back(std::move(feature));
  }
}

// Units and definitions from the table that cairn's own GeoPackages carry.
void add_definitions(GDALDataset& dataset, std::vector<ForeignLayer>& layers) {
  OGRLayer* table = dataset.GetLayerByName("cairn_columns");
  if (table == nullptr) return;
  const OGRFeatureDefn& definition = *table->GetLayerDefn();
  for (const char* name : {"layer", "name", "unit", "definition"})
    if (definition.GetFieldIndex(name) < 0) return;
  std::map<std::pair<std::string, std::string>, std::pair<std::string, std::string>> known;
  constexpr std::size_t kMaxRows = 100'000;
  table->ResetReading();
  while (const std::unique_ptr<OGRFeature> row{table->GetNextFeature()}) {
    if (known.size() >= kMaxRows) break;
    known[{row->GetFieldAsString("layer"), row->GetFieldAsString("name")}] = {row->GetFieldAsString("unit"),
                                                                              row->GetFieldAsString("definition")};
  }
  for (auto& layer : layers)
    for (auto& column : layer.columns)
      if (const auto it = known.find({layer.name, column.name}); it != known.end())
        std::tie(column.unit, column.definition) = it->second;
}

std::vector<ForeignLayer> read(const std::filesystem::path& path, const std::optional<VectorLimits>& limits) {
  start_gdal();
  const GdalMessages messages;
  const Dataset dataset = open_vector(path, messages);
  std::vector<ForeignLayer> layers;
  Budget budget{limits ? limits->features : 0, limits ? limits->vertices : 0, path};
  for (OGRLayer* in : dataset->GetLayers()) {
    const std::string name = in->GetName();
    if (name == "layer_styles" || name == "cairn_columns") continue;
    layers.push_back(describe(*in));
    if (limits) read_features(*in, layers.back(), budget);
    if (messages.failed()) messages.raise(ErrorCode::invalid_input, "a layer that cannot be read", path);
  }
  add_definitions(*dataset, layers);
  return layers;
}

}  // namespace

std::vector<ForeignLayer> read_vector(const std::filesystem::path& path, const VectorLimits& limits) {
  return read(path, limits);
}

std::vector<ForeignLayer> vector_info(const std::filesystem::path& path) {
  return read(path, std::nullopt);
}

}  // namespace cairn::io
