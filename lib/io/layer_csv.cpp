#include "io/layer_csv.hpp"

#include "base/atomic_file.hpp"

namespace cairn::io {
namespace {

std::string cell(const Value& value) {
  std::string text = to_text(value);
  if (!std::holds_alternative<std::string>(value)) return text;
  if (!text.empty() && std::string_view("=+-@\t\r").find(text.front()) != std::string_view::npos) text.insert(0, "'");
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace

std::string csv_text(const Layer& layer) {
  validate(layer);
  std::string text;
  for (std::size_t c = 0; c < layer.columns.size(); ++c) text += (c == 0 ? "" : ",") + layer.columns[c].name;
  text += "\n";
  for (const auto& feature : layer.features) {
    for (std::size_t c = 0; c < feature.values.size(); ++c) text += (c == 0 ? "" : ",") + cell(feature.values[c]);
    text += "\n";
  }
  return text;
}

void write_layer_csv(const std::filesystem::path& path, const Layer& layer) {
  base::write_file(path, csv_text(layer));
}

}  // namespace cairn::io
