#include "io/xyz.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/number_text.hpp"
#include "io/bytes.hpp"
#include "io/cloud_columns.hpp"

namespace cairn::io {
namespace {

using geometry::ScalarType;

constexpr std::size_t kMaxColumns = 256;

bool is_comment(std::string_view line) {
  return line.starts_with('#') || line.starts_with("//");
}

char separator_of(std::string_view line) {
  for (const char c : {';', ',', '\t'})
    if (line.find(c) != std::string_view::npos) return c;
  return ' ';
}

// Fields of a line, at most kMaxColumns + 1.
void split(std::string_view line, char separator, std::vector<std::string_view>& fields) {
  fields.clear();
  if (separator == ' ') {
    for (std::string_view word = take_word(line); !word.empty() && fields.size() <= kMaxColumns; word = take_word(line))
      fields.push_back(word);
    return;
  }
  for (;;) {
    const std::size_t end = std::min(line.find(separator), line.size());
    fields.push_back(base::trim(line.substr(0, end)));
    if (end == line.size() || fields.size() > kMaxColumns) return;
    line.remove_prefix(end + 1);
    if (base::trim(line).empty()) return;  // a separator at the end of the line
  }
}

std::string lower(std::string_view text) {
  std::string result;
  for (const char c : text)
    if (c != '"') result += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return result;
}

std::string canonical_name(std::string_view word) {
  const std::string name = lower(word);
  constexpr std::array<std::pair<std::string_view, std::string_view>, 15> kNames = {{
      {"easting", "x"},
      {"east", "x"},
      {"e", "x"},
      {"x_m", "x"},
      {"northing", "y"},
      {"north", "y"},
      {"n", "y"},
      {"y_m", "y"},
      {"height", "z"},
      {"elevation", "z"},
      {"altitude", "z"},
      {"h", "z"},
      {"z_m", "z"},
      {"rf", "red"},
      {"class", "classification"},
  }};
  for (const auto& [from, to] : kNames)
    if (name == from) return std::string(to);
  std::string kept = printable_text(std::as_bytes(std::span(word)));
  std::erase(kept, '"');
  return kept;
}

bool all_numbers(const std::vector<std::string_view>& fields) {
  return std::ranges::all_of(fields, [](std::string_view f) { return parse_number(f).has_value(); });
}

bool names_xyz(const std::vector<std::string_view>& fields) {
  std::array<int, 3> seen{};
  for (const auto f : fields) {
    const std::string name = canonical_name(f);
    for (std::size_t k = 0; k < 3; ++k)
      if (lower(name) == std::string_view("xyz").substr(k, 1)) ++seen[k];
  }
  return seen[0] == 1 && seen[1] == 1 && seen[2] == 1;
}

std::string_view without_marks(std::string_view line) {
  while (line.starts_with('#') || line.starts_with('/')) line.remove_prefix(1);
  return base::trim(line);
}

std::string finite_text(double v, double otherwise) {
  return base::to_text(std::isfinite(v) ? v : otherwise);
}

struct Table {
  char separator = ' ';
  std::vector<std::string> names;  // empty: not given
};

// Colours as text are 0..255 by habit, 0..65535 or 0..1 in some files: decided by the largest value.
double colour_scale(const std::vector<std::vector<double>>& columns, const std::array<std::size_t, 3>& which) {
  double largest = 0.0;
  bool whole = true;
  for (const std::size_t c : which)
    for (const double v : columns[c]) {
      if (std::isfinite(v)) largest = std::max(largest, v);
      whole = whole && v == std::floor(v);
    }
  if (largest <= 1.0 && !whole) return 65535.0;
  return largest <= 255.0 ? 257.0 : 1.0;
}

void move_columns(std::vector<std::vector<double>>& columns, const std::vector<NamedColumn>& names, CloudData& data) {
  int positions = 0;
  const std::vector<Slot> slots = assign_slots(names, positions);
  auto& cloud = data.cloud;
  const std::size_t n = columns[0].size();
  std::array<std::size_t, 3> colour{};
  bool coloured = false;
  cloud.positions.resize(n);
  for (std::size_t c = 0; c < slots.size(); ++c) {
    const auto axis = static_cast<std::size_t>(slots[c].axis);
    switch (slots[c].role) {
      case Role::position:
        for (std::size_t i = 0; i < n; ++i) cloud.positions[i][slots[c].axis] = columns[c][i];
        break;
      case Role::normal:
        cloud.normals.resize(n);
        for (std::size_t i = 0; i < n; ++i) cloud.normals[i][slots[c].axis] = columns[c][i];
        break;
      case Role::colour:
        colour[axis] = c;
        coloured = true;
        break;
      case Role::gps_time: cloud.gps_time = std::move(columns[c]); break;
      default: {
        const std::string name = lower(names[c].name);
        const double top = name == "classification" ? 255.0 : (name == "intensity" ? 65535.0 : -1.0);
        const bool fits =
            std::ranges::all_of(columns[c], [&](double v) { return v >= 0.0 && v <= top && v == std::floor(v); });
        if (fits && name == "classification")
          for (const double v : columns[c]) cloud.classification.push_back(static_cast<std::uint8_t>(v));
        else if (fits && name == "intensity")
          for (const double v : columns[c]) cloud.intensity.push_back(static_cast<std::uint16_t>(v));
        else cloud.scalars.push_back({names[c].name, ScalarType::f64, "", std::move(columns[c])});
        break;
      }
    }
  }
  if (!coloured) return;
  const double scale = colour_scale(columns, colour);
  cloud.colours.resize(n);
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < n; ++i) {
      const double v = columns[colour[k]][i] * scale;
      cloud.colours[i][k] =
          static_cast<std::uint16_t>(std::isfinite(v) ? std::clamp(std::round(v), 0.0, 65535.0) : 0.0);
    }
}

}  // namespace

bool looks_like_xyz(std::string_view head) {
  TextReader in(head, "");
  std::vector<std::string_view> fields;
  for (auto line = in.next_line(); line; line = in.next_line()) {
    if (in.remaining() == 0 && in.line() > 1) return false;  // perhaps cut in the middle
    if (std::ranges::any_of(*line, [](char c) { return c == '\0' || (c > '\0' && c < '\t'); })) return false;
    const std::string_view text = base::trim(*line);
    if (text.empty() || is_comment(text)) continue;
    split(text, separator_of(text), fields);
    return fields.size() >= 3 && fields.size() <= kMaxColumns && (all_numbers(fields) || names_xyz(fields));
  }
  return false;
}

CloudData read_xyz(const std::filesystem::path& path) {
  const FileBytes file(path);
  std::string_view text = file.text();
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  TextReader in(text, file.name());
  CloudData data;
  data.facts.format = "XYZ";
  Table table;
  std::vector<std::string_view> fields;
  std::string_view last_comment;
  std::vector<std::vector<double>> columns;
  bool started = false;
  while (const auto next = in.next_line()) {
    const std::string_view line = base::trim(*next);
    if (line.empty()) continue;
    if (is_comment(line)) {
      last_comment = without_marks(line);
      if (data.facts.comments.size() < 16)
        data.facts.comments.push_back(printable_text(std::as_bytes(std::span(last_comment))));
      continue;
    }
    if (!started) {
      if (table.names.empty()) table.separator = separator_of(line);
      split(line, table.separator, fields);
      if (fields.size() < 3 || fields.size() > kMaxColumns)
        throw in.error("not a table of points").found(std::to_string(fields.size()) + " columns").allowed("3 to 256");
      if (table.names.empty() && !all_numbers(fields)) {
        if (!names_xyz(fields))
          throw in.error("the first line is neither numbers nor names of columns")
              .allowed("numbers, or names with x, y and z");
        for (const auto f : fields) table.names.push_back(canonical_name(f));
        continue;
      }
      started = true;
      columns.resize(fields.size());
      if (table.names.empty() && !last_comment.empty()) {
        std::vector<std::string_view> words;
        split(last_comment, separator_of(last_comment), words);
        if (words.size() == fields.size() && names_xyz(words))
          for (const auto w : words) table.names.push_back(canonical_name(w));
      }
      if (table.names.empty())
        for (std::size_t c = 0; c < fields.size(); ++c)
          table.names.push_back(c < 3 ? std::string(1, "xyz"[c]) : "column_" + std::to_string(c + 1));
    } else {
      split(line, table.separator, fields);
    }
    if (fields.size() != table.names.size())
      throw in.error("a line with another number of columns")
          .found(std::to_string(fields.size()))
          .allowed(std::to_string(table.names.size()));
    for (std::size_t c = 0; c < fields.size(); ++c) {
      const auto v = parse_number(fields[c]);
      if (!v)
        throw in.error("not a number")
            .found("'" + printable_text(std::as_bytes(std::span(fields[c].substr(0, 40)))) + "'");
      columns[c].push_back(*v);
    }
  }
  if (table.names.empty())
    throw bad_line(file.name(), std::max<std::uint64_t>(in.line(), 1), "the file holds no points")
        .allowed("a line of 3 or more numbers");
  columns.resize(table.names.size());
  std::vector<NamedColumn> names;
  for (const auto& name : table.names) names.push_back({name, ScalarType::f64, false});
  data.facts.version =
      table.separator == ' '
          ? "blank-separated"
          : (table.separator == '\t' ? "tab-separated" : std::string("separated by '") + table.separator + "'");
  move_columns(columns, names, data);
  data.facts.declared_points = data.cloud.size();
  drop_non_finite(data);
  return data;
}

void write_xyz(const std::filesystem::path& path, const geometry::PointCloud& cloud) {
  const auto bad = [&](std::string message) {
    return base::Error(base::ErrorCode::invalid_argument, std::move(message)).file(path.string());
  };
  if (!cloud.consistent()) throw bad("the columns of the cloud differ in length");
  std::string line = "x,y,z";
  if (!cloud.normals.empty()) line += ",nx,ny,nz";
  if (!cloud.colours.empty()) line += ",red,green,blue";
  if (!cloud.intensity.empty()) line += ",intensity";
  if (!cloud.classification.empty()) line += ",classification";
  if (!cloud.gps_time.empty()) line += ",gps_time";
  for (const auto& column : cloud.scalars) {
    std::string name = column.name;
    for (char& c : name)
      if (c < ' ' || c == ',' || c == '"' || c == ';') c = '_';
    line += "," + name;
  }
  OutputFile out(path);
  out.write(line += '\n');
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto& p = cloud.positions[i];
    if (!p.allFinite()) throw bad("a coordinate is not finite").record("point " + std::to_string(i));
    line = base::to_text(p.x()) + "," + base::to_text(p.y()) + "," + base::to_text(p.z());
    if (!cloud.normals.empty())
      for (int axis = 0; axis < 3; ++axis) line += "," + finite_text(cloud.normals[i][axis], 0.0);
    if (!cloud.colours.empty())
      for (const std::uint16_t c : cloud.colours[i]) line += "," + std::to_string(c >> 8U);
    if (!cloud.intensity.empty()) line += "," + std::to_string(cloud.intensity[i]);
    if (!cloud.classification.empty()) line += "," + std::to_string(cloud.classification[i]);
    if (!cloud.gps_time.empty()) line += "," + finite_text(cloud.gps_time[i], 0.0);
    for (const auto& column : cloud.scalars) line += "," + finite_text(column.values[i], kNoDataValue);
    out.write(line += '\n');
  }
  out.close();
}

}  // namespace cairn::io
