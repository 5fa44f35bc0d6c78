// Vector layers as plain data: what every vector writer takes and what the reader gives.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "geodesy/local_frame.hpp"
#include "geometry/geodetic.hpp"
#include "geometry/primitives.hpp"
#include "geometry/vec.hpp"
#include "io/layer_style.hpp"
#include "survey/manifest.hpp"

namespace cairn::io {

enum class ColumnType { integer, real, text, boolean };
[[nodiscard]] std::string_view name_of(ColumnType type);

// One attribute. The name is snake_case and carries the unit where it is not SI-bare ("height_m").
struct Column {
  std::string name;
  ColumnType type = ColumnType::text;
  std::string unit;        // "m", "deg", "" for none
  std::string definition;  // one sentence
};

// monostate = not known (NULL, empty cell, null). Reals that are not finite are written so too.
using Value = std::variant<std::monostate, bool, std::int64_t, double, std::string>;

enum class GeometryKind { none, point, line, polygon };
[[nodiscard]] std::string_view name_of(GeometryKind kind);

// Parts of rings of points. point: one ring of one point a part; line: one ring a part; polygon: the
// outer ring, then its holes, without a repeated last vertex. More than one part = a multi-geometry.
// No parts = no geometry.
template <typename Point>
struct BasicFeature {
  std::vector<std::vector<std::vector<Point>>> parts;
  std::vector<Value> values;  // one a column
};
using Feature = BasicFeature<geometry::Geodetic>;

// A layer to be written. Positions are on WGS84; what their heights are measured from is said here.
struct Layer {
  std::string name;   // table or file name, [a-z0-9_]
  std::string title;  // one sentence
  GeometryKind kind = GeometryKind::point;
  bool with_heights = true;  // whether vertices carry their height
  survey::HeightType height_type = survey::HeightType::unknown;
  std::string geoid;  // with orthometric: "egm96"
  std::vector<Column> columns;
  std::vector<Feature> features;  // in record order; feature ids are 1..n in that order
  std::optional<LayerStyle> style;

  [[nodiscard]] std::size_t column(std::string_view column_name) const;  // columns.size() where there is none
};

// Throws invalid_argument where a name is empty, doubled or not [a-z0-9_], where a feature has another
// number of values than there are columns, a value of another type, a shape that does not fit the
// kind, or a position that is not finite or outside the Earth.
void validate(const Layer& layer);

// Local ENU -> features' positions.
[[nodiscard]] std::vector<geometry::Geodetic> to_geodetic(const geodesy::LocalFrame& frame,
                                                          std::span<const geometry::Vec3> points);
// A ring of local east, north at one local up [m].
[[nodiscard]] std::vector<geometry::Geodetic> to_geodetic(const geodesy::LocalFrame& frame, const geometry::Ring& ring,
                                                          double up);

// "ellipsoidal", "orthometric (egm96)", "relative_takeoff", "unknown": the words for height_type columns.
[[nodiscard]] std::string height_type_text(survey::HeightType type, const std::string& geoid);

// Value as text: "" for unknown, shortest round-trip reals, "true"/"false".
[[nodiscard]] std::string to_text(const Value& value);

}  // namespace cairn::io
