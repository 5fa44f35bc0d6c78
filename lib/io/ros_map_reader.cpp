// The reading half of ros_map.hpp: a small YAML subset, and nav2's rules for pixels.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/map_image.hpp"
#include "io/ros_map.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;

constexpr std::uintmax_t kMaxYamlBytes = 65536;

struct Entry {
  std::string value;
  std::size_t line = 0;
};

// Flat "key: value" lines, with comments, quotes and one-line lists: all that map files need. Nested
// blocks, anchors, tags and multi-line values are refused.
class YamlFile {
 public:
  explicit YamlFile(const std::filesystem::path& path) : path_(path.string()) {
    const std::string text = base::read_file(path, kMaxYamlBytes);
    std::size_t line = 0;
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      read_line(std::string_view(text).substr(begin, end - begin), ++line);
      begin = end + 1;
    }
  }

  [[nodiscard]] const Entry* find(const std::string& key) const {
    const auto it = entries_.find(key);
    return it == entries_.end() ? nullptr : &it->second;
  }
  [[nodiscard]] const Entry& at(const std::string& key) const {
    const Entry* entry = find(key);
    if (entry == nullptr)
      throw Error(ErrorCode::invalid_input, "a map without the key '" + key + "'")
          .file(path_)
          .allowed("image, resolution, origin, negate, occupied_thresh, free_thresh, mode");
    return *entry;
  }
  [[nodiscard]] double real(const std::string& key, double lo, double hi) const {
    const Entry& entry = at(key);
    return number(entry, entry.value, lo, hi);
  }
  [[nodiscard]] double number(const Entry& entry, std::string_view text, double lo, double hi) const {
    const auto value = base::parse_real(text);
    if (!value || !(*value >= lo && *value <= hi))
      refuse(entry.line, "a number that is out of place", std::string(text),
             base::to_text(lo) + " to " + base::to_text(hi));
    return *value;
  }
  [[noreturn]] void refuse(std::size_t line, std::string message, const std::string& found,
                           const std::string& allowed) const {
    throw Error(ErrorCode::invalid_input, std::move(message))
        .file(path_)
        .record("line " + std::to_string(line))
        .found("'" + found.substr(0, 80) + "'")
        .allowed(allowed);
  }

 private:
  void read_line(std::string_view raw, std::size_t line) {
    const std::string_view content = base::trim(raw);
    if (content.empty() || content.front() == '#' || content == "---") return;
    const std::size_t colon = content.find(':');
    if (colon == std::string_view::npos || raw.front() == ' ' || raw.front() == '\t')
      refuse(line, "a line that is not 'key: value'", std::string(content), "flat keys; lists on one line");
    const std::string key(base::trim(content.substr(0, colon)));
    const std::string value = unquoted(base::trim(content.substr(colon + 1)), line);
    if (value.empty()) refuse(line, "a key without a value on its line", key, "key: value");
    if (!entries_.emplace(key, Entry{value, line}).second) refuse(line, "a key that is there twice", key, "once");
  }

  [[nodiscard]] std::string unquoted(std::string_view text, std::size_t line) const {
    if (text.empty()) return "";
    const char quote = text.front();
    if (quote == '"' || quote == '\'') {
      const std::size_t end = text.find(quote, 1);
      const std::string_view rest =
          end == std::string_view::npos ? std::string_view() : base::trim(text.substr(end + 1));
      const std::string_view inside = text.substr(1, end == std::string_view::npos ? end : end - 1);
      if (end == std::string_view::npos || (!rest.empty() && rest.front() != '#') ||
          inside.find('\\') != std::string_view::npos)
        refuse(line, "a quoted text that does not end, or with escapes", std::string(text), "'text' or \"text\"");
      return std::string(inside);
    }
    if (std::string_view("&*!|>%@`{").find(quote) != std::string_view::npos)
      refuse(line, "YAML that map files do not need", std::string(text), "plain values");
    const std::size_t comment = text.find(" #");
    return std::string(base::trim(text.substr(0, comment)));
  }

  std::string path_;
  std::map<std::string, Entry> entries_;
};

std::vector<double> list_of_three(const YamlFile& yaml, const std::string& key) {
  const Entry& entry = yaml.at(key);
  const std::string& text = entry.value;
  std::vector<double> values;
  if (text.size() >= 2 && text.front() == '[' && text.back() == ']') {
    constexpr double kFar = 1e9;
    const std::string_view inside = std::string_view(text).substr(1, text.size() - 2);
    for (std::size_t begin = 0; begin <= inside.size() && values.size() < 4;) {
      const std::size_t end = std::min(inside.find(',', begin), inside.size());
      values.push_back(yaml.number(entry, inside.substr(begin, end - begin), -kFar, kFar));
      begin = end + 1;
    }
  }
  if (values.size() != 3) yaml.refuse(entry.line, "a list that is not [x, y, yaw]", text, "three numbers");
  return values;
}

bool negate_of(const YamlFile& yaml) {
  const Entry& entry = yaml.at("negate");
  if (entry.value == "0" || entry.value == "false") return false;
  if (entry.value == "1" || entry.value == "true") return true;
  yaml.refuse(entry.line, "a negate that is neither yes nor no", entry.value, "0, 1, false, true");
}

MapMode mode_of(const YamlFile& yaml) {
  const Entry* entry = yaml.find("mode");
  if (entry == nullptr) return MapMode::trinary;
  for (const MapMode mode : {MapMode::trinary, MapMode::scale, MapMode::raw})
    if (entry->value == name_of(mode)) return mode;
  yaml.refuse(entry->line, "an unknown mode", entry->value, "trinary, scale, raw");
}

// The image, which must be inside the YAML's folder even when links are followed.
std::filesystem::path image_path(const YamlFile& yaml, const std::filesystem::path& yaml_path) {
  namespace fs = std::filesystem;
  const Entry& entry = yaml.at("image");
  std::error_code error;
  const fs::path folder = fs::weakly_canonical(fs::absolute(yaml_path).parent_path(), error);
  const fs::path image = fs::weakly_canonical(folder / entry.value, error);
  const fs::path inside = image.lexically_relative(folder);
  if (error || inside.empty() || *inside.begin() == ".." || entry.value.find('\0') != std::string::npos)
    yaml.refuse(entry.line, "an image outside the map's folder", entry.value, "a path inside it");
  if (!fs::is_regular_file(image, error))
    throw Error(ErrorCode::not_found, "the map's image is not there")
        .file(yaml_path.string())
        .record("line " + std::to_string(entry.line))
        .found("'" + entry.value + "'");
  return image;
}

// Brightness 0..1 as Nav2 sees it: the mean of red, green and blue, and in trinary mode of the opacity too.
double shade_of(const MapImage& image, std::size_t pixel, MapMode mode) {
  const double colour = image.colour[pixel];
  if (mode == MapMode::trinary && !image.opacity.empty())
    return (colour + static_cast<double>(image.opacity[pixel])) / (4.0 * image.maximum);
  return colour / (3.0 * image.maximum);
}

std::uint8_t occupancy(const RosMap& map, bool negate, double shade) {
  if (map.mode == MapMode::raw) {
    const double value = std::round(shade * 255.0);
    return value <= 100.0 ? static_cast<std::uint8_t>(value) : kOccupancyUnknown;
  }
  const double occ = negate ? shade : 1.0 - shade;
  if (occ > map.occupied_thresh) return 100;
  if (occ < map.free_thresh) return 0;
  if (map.mode == MapMode::trinary) return kOccupancyUnknown;
  return static_cast<std::uint8_t>(
      std::rint((occ - map.free_thresh) / (map.occupied_thresh - map.free_thresh) * 100.0));
}

}  // namespace

std::filesystem::path ros_map_image(const std::filesystem::path& path) {
  return image_path(YamlFile(path), path);
}

RosMap read_ros_map(const std::filesystem::path& path, const RosMapReading& reading) {
  const YamlFile yaml(path);
  RosMap map;
  map.mode = mode_of(yaml);
  map.occupied_thresh = yaml.real("occupied_thresh", 0.0, 1.0);
  map.free_thresh = yaml.real("free_thresh", 0.0, 1.0);
  if (map.mode != MapMode::raw && !(map.free_thresh < map.occupied_thresh))
    yaml.refuse(yaml.at("free_thresh").line, "thresholds that do not part free from occupied",
                base::to_text(map.free_thresh), "less than occupied_thresh");
  const bool negate = negate_of(yaml);
  const double cell = yaml.real("resolution", 1e-6, 1e6);
  const auto origin = list_of_three(yaml, "origin");
  if (origin[2] != 0.0 && !reading.accept_yaw)
    yaml.refuse(yaml.at("origin").line, "a turned map", "yaw " + base::to_text(origin[2]),
                "yaw 0: Nav2 ignores it, so the map would lie wrongly");
  map.yaw = origin[2];
  const MapImage image = read_map_image(image_path(yaml, path));
  map.occupancy.geometry = {origin[0], origin[1] + cell * static_cast<double>(image.rows), cell, image.columns,
                            image.rows};
  map.occupancy.values.resize(image.colour.size());
  for (std::size_t i = 0; i < image.colour.size(); ++i) {
    const bool seen_through = map.mode == MapMode::scale && !image.opacity.empty() && image.opacity[i] != image.maximum;
    map.occupancy.values[i] = seen_through ? kOccupancyUnknown : occupancy(map, negate, shade_of(image, i, map.mode));
  }
  return map;
}

}  // namespace cairn::io
