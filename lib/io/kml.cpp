#include "io/kml.hpp"

#include <array>

#include "base/atomic_file.hpp"
#include "base/number_text.hpp"
#include "geodesy/crs.hpp"

namespace cairn::io {
namespace {

using geometry::Geodetic;
using survey::HeightType;

constexpr int kDegreeDecimals = 9;
constexpr int kMetreDecimals = 3;

std::string hex(const Colour& c) {
  constexpr std::array<char, 17> kDigits{"0123456789abcdef"};
  std::string text;
  for (const unsigned v : {unsigned{c.alpha}, unsigned{c.blue}, unsigned{c.green}, unsigned{c.red}}) {
    text += kDigits[v >> 4U];
    text += kDigits[v & 15U];
  }
  return text;
}

std::string style_element(const std::string& id, const LayerStyle& style, const Colour& fill) {
  return "<Style id=\"" + id + "\"><IconStyle><color>" + hex(fill) +
         "</color><scale>0.7</scale></IconStyle><LabelStyle><scale>0.7</scale></LabelStyle><LineStyle><color>" +
         hex(style.outline) + "</color><width>1.5</width></LineStyle><PolyStyle><color>" + hex(fill) +
         "</color></PolyStyle></Style>\n";
}

class FolderWriter {
 public:
  FolderWriter(const Layer& layer, const std::string& name_column)
      : layer_(layer),
        style_(layer.style.value_or(LayerStyle{})),
        name_column_(layer.column(name_column)),
        style_column_(layer.column(style_.column)),
        absolute_(layer.with_heights && (layer.height_type == HeightType::ellipsoidal ||
                                         (layer.height_type == HeightType::orthometric && layer.geoid == "egm96"))) {}

  [[nodiscard]] std::string styles() const {
    std::string text;
    for (std::size_t i = 0; i < style_.classes.size(); ++i)
      text += style_element(style_id(i), style_, style_.classes[i].fill);
    return text + style_element(style_id(style_.classes.size()), style_, style_.other);
  }

  [[nodiscard]] std::string folder() const {
    std::string text = "<Folder><name>" + xml_escaped(layer_.name) + "</name><description>" +
                       xml_escaped(layer_.title.empty() ? heights() : layer_.title + ". " + heights()) +
                       "</description>\n";
    for (std::size_t i = 0; i < layer_.features.size(); ++i) text += placemark(i);
    return text + "</Folder>\n";
  }

 private:
  [[nodiscard]] std::string style_id(std::size_t i) const { return layer_.name + "-" + std::to_string(i); }

  [[nodiscard]] std::string heights() const {
    if (!absolute_)
      return "Clamped to the ground: heights are of type " + height_type_text(layer_.height_type, layer_.geoid) +
             ", which KML cannot place";
    return layer_.height_type == HeightType::ellipsoidal
               ? "Altitudes are above EGM96 sea level, converted from ellipsoidal heights"
               : "Altitudes are above EGM96 sea level";
  }

  [[nodiscard]] std::string position(const Geodetic& g) const {
    std::string text =
        base::to_fixed(g.longitude_deg, kDegreeDecimals) + "," + base::to_fixed(g.latitude_deg, kDegreeDecimals);
    if (!absolute_) return text;
    double height = g.height_m;
    if (layer_.height_type == HeightType::ellipsoidal) height -= geodesy::geoid_undulation("egm96", g);
    return text + "," + base::to_fixed(height, kMetreDecimals);
  }

  [[nodiscard]] std::string coordinates(const std::vector<Geodetic>& ring, bool closed) const {
    std::string text = "<coordinates>";
    for (const auto& g : ring) text += position(g) + " ";
    if (closed) text += position(ring.front());
    if (text.back() == ' ') text.pop_back();
    return text + "</coordinates>";
  }

  [[nodiscard]] std::string part(const std::vector<std::vector<Geodetic>>& rings) const {
    const std::string mode =
        std::string("<altitudeMode>") + (absolute_ ? "absolute" : "clampToGround") + "</altitudeMode>";
    if (layer_.kind == GeometryKind::point) return "<Point>" + mode + coordinates(rings[0], false) + "</Point>";
    if (layer_.kind == GeometryKind::line)
      return "<LineString><tessellate>1</tessellate>" + mode + coordinates(rings[0], false) + "</LineString>";
    std::string text = "<Polygon><tessellate>1</tessellate>" + mode;
    for (std::size_t i = 0; i < rings.size(); ++i) {
      const std::string boundary = i == 0 ? "outerBoundaryIs" : "innerBoundaryIs";
      text += "<" + boundary + "><LinearRing>" + coordinates(rings[i], true) + "</LinearRing></" + boundary + ">";
    }
    return text + "</Polygon>";
  }

  [[nodiscard]] std::size_t style_index(const Feature& feature) const {
    if (style_column_ < layer_.columns.size()) {
      const std::string value = to_text(feature.values[style_column_]);
      for (std::size_t i = 0; i < style_.classes.size(); ++i)
        if (style_.classes[i].value == value) return i;
    }
    return style_.classes.size();
  }

  [[nodiscard]] std::string placemark(std::size_t i) const {
    const Feature& feature = layer_.features[i];
    const std::string name = name_column_ < layer_.columns.size() ? to_text(feature.values[name_column_])
                                                                  : layer_.name + " " + std::to_string(i + 1);
    std::string text = "<Placemark id=\"" + layer_.name + "." + std::to_string(i + 1) + "\"><name>" +
                       xml_escaped(name) + "</name><styleUrl>#" + style_id(style_index(feature)) +
                       "</styleUrl><ExtendedData>";
    for (std::size_t c = 0; c < layer_.columns.size(); ++c) {
      const std::string value = to_text(feature.values[c]);
      if (!value.empty())
        text += "<Data name=\"" + layer_.columns[c].name + "\"><value>" + xml_escaped(value) + "</value></Data>";
    }
    text += "</ExtendedData>";
    if (feature.parts.size() > 1) text += "<MultiGeometry>";
    for (const auto& rings : feature.parts) text += part(rings);
    if (feature.parts.size() > 1) text += "</MultiGeometry>";
    return text + "</Placemark>\n";
  }

  const Layer& layer_;
  LayerStyle style_;
  std::size_t name_column_, style_column_;
  bool absolute_;
};

}  // namespace

std::string kml_text(const std::vector<Layer>& layers, const std::string& document_name,
                     const std::string& name_column) {
  std::string styles, folders;
  for (const auto& layer : layers) {
    validate(layer);
    if (layer.kind == GeometryKind::none) continue;
    const FolderWriter writer(layer, name_column);
    styles += writer.styles();
    folders += writer.folder();
  }
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\"><Document><name>" +
         xml_escaped(document_name) + "</name>\n" + styles + folders + "</Document></kml>\n";
}

void write_kml(const std::filesystem::path& path, const std::vector<Layer>& layers, const std::string& document_name,
               const std::string& name_column) {
  base::write_file(path, kml_text(layers, document_name, name_column));
}

}  // namespace cairn::io
