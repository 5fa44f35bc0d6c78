// The fixed columns of every layer cairn writes: one table for the writers and for the manual.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "io/vector_layer.hpp"

namespace cairn::report {

struct LayerSpec {
  std::string_view name;
  std::string_view title;  // one sentence
  io::GeometryKind kind = io::GeometryKind::point;
  bool with_heights = true;
  std::vector<io::Column> columns;
};

// In the order of the GeoPackage: targets, rocks, obstacles, frames, footprints, gaps.
[[nodiscard]] const std::vector<LayerSpec>& layer_table();
// Throws internal for an unknown name.
[[nodiscard]] const LayerSpec& layer_spec(std::string_view name);

// The sections of docs/formats/layers.md that describe the layers, one table each.
[[nodiscard]] std::string layer_table_markdown();

}  // namespace cairn::report
