#include "io/vector_layer.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "base/error.hpp"
#include "base/number_text.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Geodetic;

bool is_name(std::string_view name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
}

bool fits(const Value& value, ColumnType type) {
  switch (type) {
    case ColumnType::integer: return value.index() == 0 || std::holds_alternative<std::int64_t>(value);
    case ColumnType::real: return value.index() == 0 || std::holds_alternative<double>(value);
    case ColumnType::text: return value.index() == 0 || std::holds_alternative<std::string>(value);
    case ColumnType::boolean: return value.index() == 0 || std::holds_alternative<bool>(value);
  }
  return false;
}

bool is_position(const Geodetic& g) {
  return std::abs(g.latitude_deg) <= 90.0 && std::abs(g.longitude_deg) <= 180.0 && std::isfinite(g.height_m);
}

bool fits(const std::vector<std::vector<Geodetic>>& rings, GeometryKind kind) {
  switch (kind) {
    case GeometryKind::none: return false;
    case GeometryKind::point: return rings.size() == 1 && rings[0].size() == 1;
    case GeometryKind::line: return rings.size() == 1 && rings[0].size() >= 2;
    case GeometryKind::polygon:
      return !rings.empty() &&
             std::all_of(rings.begin(), rings.end(), [](const auto& ring) { return ring.size() >= 3; });
  }
  return false;
}

}  // namespace

std::string_view name_of(ColumnType type) {
  switch (type) {
    case ColumnType::integer: return "integer";
    case ColumnType::real: return "real";
    case ColumnType::text: return "text";
    case ColumnType::boolean: return "boolean";
  }
  return "text";
}

std::string_view name_of(GeometryKind kind) {
  switch (kind) {
    case GeometryKind::none: return "none";
    case GeometryKind::point: return "point";
    case GeometryKind::line: return "line";
    case GeometryKind::polygon: return "polygon";
  }
  return "none";
}

std::size_t Layer::column(std::string_view column_name) const {
  return static_cast<std::size_t>(
      std::find_if(columns.begin(), columns.end(), [&](const Column& c) { return c.name == column_name; }) -
      columns.begin());
}

void validate(const Layer& layer) {
  const auto refuse = [&](std::string message, const std::string& record) {
    throw Error(ErrorCode::invalid_argument, std::move(message)).file("layer '" + layer.name + "'").record(record);
  };
  if (!is_name(layer.name)) refuse("a layer name that is not [a-z0-9_]", "name");
  std::set<std::string_view> names;
  for (const auto& column : layer.columns) {
    if (!is_name(column.name)) refuse("a column name that is not [a-z0-9_]", "column '" + column.name + "'");
    if (column.name == "fid" || column.name == "geom" || !names.insert(column.name).second)
      refuse("a column name that is taken", "column '" + column.name + "'");
  }
  for (std::size_t i = 0; i < layer.features.size(); ++i) {
    const Feature& feature = layer.features[i];
    const std::string record = "feature " + std::to_string(i + 1);
    if (feature.values.size() != layer.columns.size()) refuse("a feature without one value a column", record);
    for (std::size_t c = 0; c < layer.columns.size(); ++c)
      if (!fits(feature.values[c], layer.columns[c].type))
        refuse("a value of another type than its column", record + ", column '" + layer.columns[c].name + "'");
    for (const auto& rings : feature.parts) {
      if (!fits(rings, layer.kind)) refuse("a shape that is no " + std::string(name_of(layer.kind)), record);
      for (const auto& ring : rings)
        for (const auto& position : ring)
          if (!is_position(position)) refuse("a position that is not on the Earth", record);
    }
  }
}

std::vector<Geodetic> to_geodetic(const geodesy::LocalFrame& frame, std::span<const geometry::Vec3> points) {
  std::vector<Geodetic> out;
  out.reserve(points.size());
  for (const auto& p : points) out.push_back(frame.to_geodetic(p));
  return out;
}

std::vector<Geodetic> to_geodetic(const geodesy::LocalFrame& frame, const geometry::Ring& ring, double up) {
  std::vector<Geodetic> out;
  out.reserve(ring.size());
  for (const auto& p : ring) out.push_back(frame.to_geodetic({p.x(), p.y(), up}));
  return out;
}

std::string height_type_text(survey::HeightType type, const std::string& geoid) {
  std::string text(survey::name_of(type));
  if (type == survey::HeightType::orthometric && !geoid.empty()) text += " (" + geoid + ")";
  return text;
}

std::string to_text(const Value& value) {
  if (const auto* b = std::get_if<bool>(&value)) return *b ? "true" : "false";
  if (const auto* i = std::get_if<std::int64_t>(&value)) return std::to_string(*i);
  if (const auto* d = std::get_if<double>(&value)) return std::isfinite(*d) ? base::to_text(*d) : "";
  if (const auto* s = std::get_if<std::string>(&value)) return *s;
  return "";
}

}  // namespace cairn::io
