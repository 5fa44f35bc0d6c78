#include "io/layer_style.hpp"

#include "base/number_text.hpp"
#include "io/vector_layer.hpp"

namespace cairn::io {
namespace {

std::string rgba(const Colour& c) {
  return std::to_string(c.red) + "," + std::to_string(c.green) + "," + std::to_string(c.blue) + "," +
         std::to_string(c.alpha);
}

// QGIS before 3.26 reads <prop>, later versions read <Option>: both are written, as QGIS itself did.
class SymbolLayer {
 public:
  void add(const std::string& key, const std::string& value) {
    options_ += "<Option type=\"QString\" name=\"" + key + "\" value=\"" + xml_escaped(value) + "\"/>";
    props_ += "<prop k=\"" + key + "\" v=\"" + xml_escaped(value) + "\"/>";
  }
  [[nodiscard]] std::string text(const std::string& layer_class) const {
    return "<layer class=\"" + layer_class + "\" enabled=\"1\" locked=\"0\" pass=\"0\"><Option type=\"Map\">" +
           options_ + "</Option>" + props_ + "</layer>";
  }

 private:
  std::string options_, props_;
};

std::string symbol(const LayerStyle& style, GeometryKind kind, const Colour& fill, std::size_t index) {
  SymbolLayer layer;
  std::string type, layer_class;
  const std::string width = base::to_text(style.outline_mm);
  if (kind == GeometryKind::point) {
    type = "marker";
    layer_class = "SimpleMarker";
    layer.add("color", rgba(fill));
    layer.add("name", style.marker);
    layer.add("outline_color", rgba(style.outline));
    layer.add("outline_style", "solid");
    layer.add("outline_width", width);
    layer.add("outline_width_unit", "MM");
    layer.add("size", base::to_text(style.marker_mm));
    layer.add("size_unit", "MM");
  } else if (kind == GeometryKind::line) {
    type = "line";
    layer_class = "SimpleLine";
    layer.add("line_color", rgba(fill));
    layer.add("line_style", "solid");
    layer.add("line_width", width);
    layer.add("line_width_unit", "MM");
  } else {
    type = "fill";
    layer_class = "SimpleFill";
    layer.add("color", rgba(fill));
    layer.add("style", fill.alpha == 0 ? "no" : "solid");
    layer.add("outline_color", rgba(style.outline));
    layer.add("outline_style", "solid");
    layer.add("outline_width", width);
    layer.add("outline_width_unit", "MM");
  }
  return "<symbol type=\"" + type + "\" name=\"" + std::to_string(index) +
         "\" alpha=\"1\" clip_to_extent=\"1\" force_rhr=\"0\">" + layer.text(layer_class) + "</symbol>";
}

std::string categories(const LayerStyle& style) {
  std::string text;
  for (std::size_t i = 0; i < style.classes.size(); ++i)
    text += "<category type=\"string\" render=\"true\" symbol=\"" + std::to_string(i) + "\" value=\"" +
            xml_escaped(style.classes[i].value) + "\" label=\"" + xml_escaped(style.classes[i].label) + "\"/>";
  // An empty value is QGIS's "all other values".
  return text + "<category type=\"string\" render=\"true\" symbol=\"" + std::to_string(style.classes.size()) +
         "\" value=\"\" label=\"other\"/>";
}

std::string labels(const LayerStyle& style) {
  return "<labeling type=\"simple\"><settings calloutType=\"simple\"><text-style fieldName=\"" +
         xml_escaped(style.label_column) +
         "\" isExpression=\"0\" fontSize=\"8\" fontSizeUnit=\"Point\" textColor=\"20,20,20,255\"><text-buffer "
         "bufferDraw=\"1\" bufferSize=\"0.8\" bufferSizeUnits=\"MM\" bufferColor=\"255,255,255,255\"/></text-style>"
         "<placement placement=\"6\" dist=\"1\" distUnits=\"MM\"/></settings></labeling>";
}

}  // namespace

std::string xml_escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      case '\'': out += "&#39;"; break;
      default:
        // XML 1.0 has no control characters but these three.
        if (static_cast<unsigned char>(c) >= 0x20 || c == '\n' || c == '\t' || c == '\r') out += c;
    }
  }
  return out;
}

std::string qml(const LayerStyle& style, GeometryKind kind) {
  if (kind == GeometryKind::none) return "";
  const bool by_value = !style.column.empty();
  std::string symbols;
  std::size_t index = 0;
  if (by_value)
    for (const auto& c : style.classes) symbols += symbol(style, kind, c.fill, index++);
  symbols += symbol(style, kind, style.other, index);
  const bool labelled = !style.label_column.empty();
  return "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n"
         "<qgis version=\"3.22.0\" styleCategories=\"Symbology|Labeling\" labelsEnabled=\"" +
         std::string(labelled ? "1" : "0") + "\">\n<renderer-v2 type=\"" +
         (by_value ? "categorizedSymbol\" attr=\"" + xml_escaped(style.column) : std::string("singleSymbol")) +
         "\" symbollevels=\"0\" enableorderby=\"0\" forceraster=\"0\">\n" +
         (by_value ? "<categories>" + categories(style) + "</categories>\n" : std::string()) + "<symbols>" + symbols +
         "</symbols>\n</renderer-v2>\n" + (labelled ? labels(style) + "\n" : std::string()) +
         "<blendMode>0</blendMode>\n<featureBlendMode>0</featureBlendMode>\n<layerOpacity>1</layerOpacity>\n</qgis>\n";
}

}  // namespace cairn::io
