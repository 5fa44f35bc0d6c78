#include "io/geojson.hpp"

#include <algorithm>
#include <cmath>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/json.hpp"

namespace cairn::io {
namespace {

using geometry::Geodetic;
using Positions = std::vector<Geodetic>;

constexpr int kDegreeDecimals = 7;
constexpr int kMetreDecimals = 3;

class Writer {
 public:
  explicit Writer(const Layer& layer)
      : layer_(layer), heights_(layer.with_heights && layer.height_type == survey::HeightType::ellipsoidal) {}

  [[nodiscard]] std::string geometry(const Feature& feature) const {
    if (feature.parts.empty()) return "null";
    const bool multi = feature.parts.size() > 1;
    std::string coordinates;
    for (const auto& rings : feature.parts) coordinates += (coordinates.empty() ? "" : ",") + part(rings);
    if (multi) coordinates = "[" + coordinates + "]";
    return "{\"type\":\"" + std::string(multi ? "Multi" : "") + kind_name() + "\",\"coordinates\":" + coordinates + "}";
  }

 private:
  [[nodiscard]] const char* kind_name() const {
    if (layer_.kind == GeometryKind::point) return "Point";
    return layer_.kind == GeometryKind::line ? "LineString" : "Polygon";
  }

  [[nodiscard]] std::string position(const Geodetic& g) const {
    std::string text =
        "[" + base::to_fixed(g.longitude_deg, kDegreeDecimals) + "," + base::to_fixed(g.latitude_deg, kDegreeDecimals);
    if (heights_) text += "," + base::to_fixed(g.height_m, kMetreDecimals);
    return text + "]";
  }

  [[nodiscard]] std::string positions(const Positions& ring, bool closed) const {
    std::string text = "[";
    for (const auto& g : ring) text += (text.size() > 1 ? "," : "") + position(g);
    if (closed) text += "," + position(ring.front());
    return text + "]";
  }

  [[nodiscard]] std::string part(const std::vector<Positions>& rings) const {
    if (layer_.kind == GeometryKind::point) return position(rings[0][0]);
    for (const auto& ring : rings) check_antimeridian(ring);
    if (layer_.kind == GeometryKind::line) return positions(rings[0], false);
    std::string text = "[";
    for (std::size_t i = 0; i < rings.size(); ++i) {
      const bool outer = i == 0;
      Positions ring = rings[i];
      if ((doubled_area(ring) > 0.0) != outer) std::reverse(ring.begin() + 1, ring.end());
      text += (outer ? "" : ",") + positions(ring, true);
    }
    return text + "]";
  }

  // In degrees; relative to the first vertex, so that small rings keep their digits.
  static double doubled_area(const Positions& ring) {
    double sum = 0.0;
    const Geodetic& o = ring.front();
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Geodetic& a = ring[i];
      const Geodetic& b = ring[(i + 1) % ring.size()];
      sum += (a.longitude_deg - o.longitude_deg) * (b.latitude_deg - o.latitude_deg) -
             (b.longitude_deg - o.longitude_deg) * (a.latitude_deg - o.latitude_deg);
    }
    return sum;
  }

  void check_antimeridian(const Positions& ring) const {
    for (const auto& g : ring)
      if (std::abs(g.longitude_deg - ring.front().longitude_deg) > 180.0)
        throw base::Error(base::ErrorCode::crs_mismatch, "a shape that crosses the antimeridian")
            .file("layer '" + layer_.name + "'")
            .allowed("shapes on one side, in GeoJSON")
            .hint("Use the GeoPackage");
  }

  const Layer& layer_;
  bool heights_;
};

Json to_json(const Value& value) {
  if (const auto* b = std::get_if<bool>(&value)) return Json(*b);
  if (const auto* i = std::get_if<std::int64_t>(&value)) return Json(*i);
  if (const auto* d = std::get_if<double>(&value)) return Json(*d);
  if (const auto* s = std::get_if<std::string>(&value)) return Json(*s);
  return Json();
}

}  // namespace

std::string geojson_text(const Layer& layer) {
  validate(layer);
  const Writer writer(layer);
  std::string text = "{\"type\":\"FeatureCollection\",\"name\":" + Json(layer.name).dump(0) + ",\"features\":[\n";
  for (std::size_t i = 0; i < layer.features.size(); ++i) {
    const Feature& feature = layer.features[i];
    Json properties = Json::object();
    for (std::size_t c = 0; c < layer.columns.size(); ++c)
      properties.set(layer.columns[c].name, to_json(feature.values[c]));
    text += "{\"type\":\"Feature\",\"id\":" + std::to_string(i + 1) + ",\"properties\":" + properties.dump(0) +
            ",\"geometry\":" + writer.geometry(feature) + "}" + (i + 1 < layer.features.size() ? ",\n" : "\n");
  }
  return text + "]}\n";
}

void write_geojson(const std::filesystem::path& path, const Layer& layer) {
  base::write_file(path, geojson_text(layer));
}

}  // namespace cairn::io
