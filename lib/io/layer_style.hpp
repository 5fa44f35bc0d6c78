// How a layer looks in QGIS: a small description, and the QML that QGIS reads.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cairn::io {

enum class GeometryKind;

struct Colour {
  std::uint8_t red = 0, green = 0, blue = 0, alpha = 255;
};

// What features with one value of the style's column look like.
struct StyleClass {
  std::string value;  // compared as text
  std::string label;
  Colour fill;
};

struct LayerStyle {
  std::string name;                 // "by grade"
  std::string column;               // "" = every feature looks like `other`
  std::vector<StyleClass> classes;  // legend order
  Colour other{128, 128, 128, 255};
  Colour outline{35, 35, 35, 255};
  double outline_mm = 0.3;        // >= 0
  std::string marker = "circle";  // of points: circle, square, diamond, triangle, cross2, ...
  double marker_mm = 3.0;         // > 0
  std::string label_column;       // "" = no labels
};

// A complete QGIS 3.22 style document for points, lines or polygons; "" for tables without geometry.
[[nodiscard]] std::string qml(const LayerStyle& style, GeometryKind kind);

// Text made safe inside XML elements and attributes; control characters are dropped.
[[nodiscard]] std::string xml_escaped(const std::string& text);

}  // namespace cairn::io
