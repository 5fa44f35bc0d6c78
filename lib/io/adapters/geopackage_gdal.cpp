#include <cpl_string.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>
#include <ogrsf_frmts.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "io/adapters/gdal_session.hpp"
#include "io/vector.hpp"

namespace cairn::io {
namespace {

using base::ErrorCode;
using geometry::Geodetic;

constexpr const char* kGeometryColumn = "geom";

struct CloseDataset {
  void operator()(GDALDataset* d) const { GDALClose(d); }
};
using Dataset = std::unique_ptr<GDALDataset, CloseDataset>;
using OwnedFeature = std::unique_ptr<OGRFeature>;
using OwnedGeometry = std::unique_ptr<OGRGeometry>;

class GeoPackageWriter {
 public:
  GeoPackageWriter(const std::string& memory_path, const std::filesystem::path& path, const GdalMessages& messages)
      : path_(path), messages_(messages) {
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GPKG");
    dataset_.reset(driver->Create(memory_path.c_str(), 0, 0, 0, GDT_Unknown, nullptr));
    check(dataset_ != nullptr);
    wgs84_.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    check(wgs84_.importFromEPSG(4326) == OGRERR_NONE);
    check(dataset_->StartTransaction() == OGRERR_NONE);
  }

  void add(const Layer& layer) {
    CPLStringList options;
    options.SetNameValue("FID", "fid");
    if (layer.kind == GeometryKind::none) {
      options.SetNameValue("ASPATIAL_VARIANT", "GPKG_ATTRIBUTES");
    } else {
      options.SetNameValue("GEOMETRY_NAME", kGeometryColumn);
      options.SetNameValue("SPATIAL_INDEX", "YES");
    }
    options.SetNameValue("IDENTIFIER", layer.name.c_str());
    if (!layer.title.empty()) options.SetNameValue("DESCRIPTION", layer.title.c_str());
    OGRLayer* out = create(layer.name, geometry_type(layer), options);
    for (const auto& column : layer.columns) add_column(*out, column);
    for (std::size_t i = 0; i < layer.features.size(); ++i) {
      const Feature& feature = layer.features[i];
      const OwnedFeature row(OGRFeature::CreateFeature(out->GetLayerDefn()));
      row->SetFID(static_cast<GIntBig>(i) + 1);
      for (std::size_t c = 0; c < feature.values.size(); ++c) set(*row, static_cast<int>(c), feature.values[c]);
      if (!feature.parts.empty())
        check(row->SetGeometryDirectly(
                  geometry(layer, feature,
                           OGR_GT_IsSubClassOf(wkbFlatten(out->GetGeomType()), wkbGeometryCollection) != 0)
                      .release()) == OGRERR_NONE);
      check(out->CreateFeature(row.get()) == OGRERR_NONE);
    }
  }

  // The table that QGIS looks into when it opens a layer (the columns are QGIS's own).
  void add_styles(const std::vector<Layer>& layers) {
    CPLStringList options;
    options.SetNameValue("FID", "id");
    options.SetNameValue("ASPATIAL_VARIANT", "GPKG_ATTRIBUTES");
    OGRLayer* out = create("layer_styles", wkbNone, options);
    for (const char* name : {"f_table_catalog", "f_table_schema", "f_table_name", "f_geometry_column", "styleName"})
      add_field(*out, name, OFTString, OFSTNone, 256);
    add_field(*out, "styleQML", OFTString);
    add_field(*out, "styleSLD", OFTString);
    add_field(*out, "useAsDefault", OFTInteger, OFSTBoolean);
    add_field(*out, "description", OFTString);
    add_field(*out, "owner", OFTString, OFSTNone, 30);
    add_field(*out, "ui", OFTString, OFSTNone, 30);
    add_field(*out, "update_time", OFTDateTime);
    GIntBig id = 0;
    for (const auto& layer : layers) {
      if (!layer.style || layer.kind == GeometryKind::none) continue;
      const OwnedFeature row(OGRFeature::CreateFeature(out->GetLayerDefn()));
      row->SetFID(++id);
      row->SetField("f_table_catalog", "");
      row->SetField("f_table_schema", "");
      row->SetField("f_table_name", layer.name.c_str());
      row->SetField("f_geometry_column", kGeometryColumn);
      row->SetField("styleName", layer.style->name.c_str());
      row->SetField("styleQML", qml(*layer.style, layer.kind).c_str());
      row->SetField("styleSLD", "");
      row->SetField("useAsDefault", 1);
      row->SetField("description", layer.title.c_str());
      row->SetField("owner", "");
      row->SetField("update_time", 2000, 1, 1, 0, 0, 0.0F, 100);
      check(out->CreateFeature(row.get()) == OGRERR_NONE);
    }
  }

  // What each column means, for people and programs alike.
  void add_column_table(const std::vector<Layer>& layers) {
    CPLStringList options;
    options.SetNameValue("FID", "fid");
    options.SetNameValue("ASPATIAL_VARIANT", "GPKG_ATTRIBUTES");
    options.SetNameValue("DESCRIPTION", "Units and definitions of the columns of the layers");
    OGRLayer* out = create("cairn_columns", wkbNone, options);
    for (const char* name : {"layer", "name", "type", "unit", "definition"}) add_field(*out, name, OFTString);
    GIntBig id = 0;
    for (const auto& layer : layers)
      for (const auto& column : layer.columns) {
        const OwnedFeature row(OGRFeature::CreateFeature(out->GetLayerDefn()));
        row->SetFID(++id);
        row->SetField("layer", layer.name.c_str());
        row->SetField("name", column.name.c_str());
        row->SetField("type", std::string(name_of(column.type)).c_str());
        row->SetField("unit", column.unit.c_str());
        row->SetField("definition", column.definition.c_str());
        check(out->CreateFeature(row.get()) == OGRERR_NONE);
      }
  }

  void finish() {
    check(dataset_->CommitTransaction() == OGRERR_NONE);
    dataset_.reset();
    check(true);
  }

 private:
  void check(bool ok) const {
    if (!ok || messages_.failed())
      messages_.raise(ErrorCode::resource_exhausted, "the GeoPackage could not be made", path_);
  }

  OGRLayer* create(const std::string& name, OGRwkbGeometryType type, const CPLStringList& options) {
    OGRLayer* layer = dataset_->CreateLayer(name.c_str(), type == wkbNone ? nullptr : &wgs84_, type,
                                            const_cast<CPLStringList&>(options).List());
    check(layer != nullptr);
    return layer;
  }

  void add_field(OGRLayer& layer, const char* name, OGRFieldType type, OGRFieldSubType subtype = OFSTNone,
                 int width = 0) const {
    OGRFieldDefn field(name, type);
    field.SetSubType(subtype);
    field.SetWidth(width);
    check(layer.CreateField(&field) == OGRERR_NONE);
  }

  void add_column(OGRLayer& layer, const Column& column) const {
    switch (column.type) {
      case ColumnType::integer: return add_field(layer, column.name.c_str(), OFTInteger64);
      case ColumnType::real: return add_field(layer, column.name.c_str(), OFTReal);
      case ColumnType::text: return add_field(layer, column.name.c_str(), OFTString);
      case ColumnType::boolean: return add_field(layer, column.name.c_str(), OFTInteger, OFSTBoolean);
    }
  }

  static void set(OGRFeature& row, int column, const Value& value) {
    if (const auto* b = std::get_if<bool>(&value)) row.SetField(column, *b ? 1 : 0);
    else if (const auto* i = std::get_if<std::int64_t>(&value)) row.SetField(column, static_cast<GIntBig>(*i));
    else if (const auto* s = std::get_if<std::string>(&value)) row.SetField(column, s->c_str());
    else if (const auto* d = std::get_if<double>(&value); d != nullptr && std::isfinite(*d)) row.SetField(column, *d);
    else row.SetFieldNull(column);
  }

  static OGRwkbGeometryType geometry_type(const Layer& layer) {
    OGRwkbGeometryType type = wkbNone;
    switch (layer.kind) {
      case GeometryKind::none: return wkbNone;
      case GeometryKind::point: type = wkbPoint; break;
      case GeometryKind::line: type = wkbLineString; break;
      case GeometryKind::polygon: type = wkbPolygon; break;
    }
    if (std::any_of(layer.features.begin(), layer.features.end(), [](const Feature& f) { return f.parts.size() > 1; }))
      type = OGR_GT_GetCollection(type);
    return layer.with_heights ? wkbSetZ(type) : type;
  }

  static void append(OGRSimpleCurve& curve, const std::vector<Geodetic>& positions, bool z, bool closed) {
    const auto add_one = [&](const Geodetic& g) {
      if (z) curve.addPoint(g.longitude_deg, g.latitude_deg, g.height_m);
      else curve.addPoint(g.longitude_deg, g.latitude_deg);
    };
    for (const auto& g : positions) add_one(g);
    if (closed) add_one(positions.front());
  }

  static OwnedGeometry part(const Layer& layer, const std::vector<std::vector<Geodetic>>& rings) {
    const bool z = layer.with_heights;
    if (layer.kind == GeometryKind::point) {
      const Geodetic& g = rings[0][0];
      return z ? std::make_unique<OGRPoint>(g.longitude_deg, g.latitude_deg, g.height_m)
               : std::make_unique<OGRPoint>(g.longitude_deg, g.latitude_deg);
    }
    if (layer.kind == GeometryKind::line) {
      auto line = std::make_unique<OGRLineString>();
      append(*line, rings[0], z, false);
      return line;
    }
    auto polygon = std::make_unique<OGRPolygon>();
    for (const auto& positions : rings) {
      auto ring = std::make_unique<OGRLinearRing>();
      append(*ring, positions, z, true);
      polygon->addRingDirectly(ring.release());
    }
    return polygon;
  }

  static OwnedGeometry geometry(const Layer& layer, const Feature& feature, bool multi) {
    if (!multi) return part(layer, feature.parts[0]);
    std::unique_ptr<OGRGeometryCollection> collection;
    if (layer.kind == GeometryKind::point) collection = std::make_unique<OGRMultiPoint>();
    else if (layer.kind == GeometryKind::line) collection = std::make_unique<OGRMultiLineString>();
    else collection = std::make_unique<OGRMultiPolygon>();
    for (const auto& rings : feature.parts) collection->addGeometryDirectly(part(layer, rings).release());
    return collection;
  }

  const std::filesystem::path& path_;
  const GdalMessages& messages_;
  Dataset dataset_;
  OGRSpatialReference wgs84_;
};

}  // namespace

void write_geopackage(const std::filesystem::path& path, const std::vector<Layer>& layers) {
  for (std::size_t i = 0; i < layers.size(); ++i) {
    validate(layers[i]);
    for (std::size_t j = 0; j < i; ++j)
      if (layers[i].name == layers[j].name)
        throw base::Error(ErrorCode::invalid_argument, "two layers of one name")
            .file(path.string())
            .found("'" + layers[i].name + "'");
  }
  start_gdal();
  const MemoryFile file(".gpkg");
  const GdalMessages messages;
  GeoPackageWriter writer(file.path(), path, messages);
  for (const auto& layer : layers) writer.add(layer);
  writer.add_styles(layers);
  writer.add_column_table(layers);
  writer.finish();
  const std::string_view bytes = file.bytes();
  if (bytes.empty()) messages.raise(ErrorCode::resource_exhausted, "the GeoPackage could not be made", path);
  base::write_file(path, bytes);
}

}  // namespace cairn::io
