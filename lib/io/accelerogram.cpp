#include "io/accelerogram.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "base/atomic_file.hpp"
#include "base/number_text.hpp"
#include "io/accelerogram_text.hpp"

namespace cairn::io {
namespace records {

using base::Error;
using base::ErrorCode;

Error Text::error(std::size_t line_index, std::string message) const {
  return Error(ErrorCode::invalid_input, std::move(message))
      .file(name)
      .record("line " + std::to_string(line_index + 1));
}

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

namespace {

bool digit(char c) {
  return c >= '0' && c <= '9';
}

// Length of the number that starts at text[0]; 0 where there is none. Sets whether it has a point.
std::size_t number_length(std::string_view text, bool& has_point) {
  std::size_t i = 0;
  has_point = false;
  if (i < text.size() && (text[i] == '+' || text[i] == '-')) ++i;
  std::size_t digits = 0;
  for (; i < text.size() && (digit(text[i]) || (text[i] == '.' && !has_point)); ++i)
    if (text[i] == '.') has_point = true;
    else ++digits;
  if (digits == 0) return 0;
  if (i < text.size() && (text[i] == 'e' || text[i] == 'E' || text[i] == 'd' || text[i] == 'D')) {
    std::size_t j = i + 1;
    if (j < text.size() && (text[j] == '+' || text[j] == '-')) ++j;
    const std::size_t first = j;
    while (j < text.size() && digit(text[j])) ++j;
    if (j == first) return 0;
    i = j;
  }
  return i;
}

}  // namespace

bool append_numbers(const Text& text, std::size_t line_index, std::size_t limit, std::vector<double>& values) {
  const std::string_view line = text.lines[line_index];
  std::size_t at = 0;
  while (at < line.size()) {
    if (line[at] == ' ' || line[at] == '\t' || line[at] == ',') {
      ++at;
      continue;
    }
    if (values.size() >= limit) return false;
    const std::string_view rest = line.substr(at);
    const std::string word(rest.substr(0, rest.find_first_of(" \t,")));
    bool point = false;
    const std::size_t length = number_length(rest, point);
    std::string number(rest.substr(0, length));
    for (char& c : number)
      if (c == 'd' || c == 'D') c = 'e';
    const auto value = length > 0 ? base::parse_real(number) : std::nullopt;
    if (!value || !std::isfinite(*value))
      throw text.error(line_index, "a value of the record is no finite number").found(word).allowed("finite numbers");
    if (length < word.size()) {
      // Two values of a fixed-width writer run together where the second is negative; each has its point.
      bool next_point = false;
      const std::string_view behind = rest.substr(length);
      const bool signed_next = behind[0] == '-' || behind[0] == '+';
      if (!signed_next || number_length(behind, next_point) == 0)
        throw text.error(line_index, "a value of the record is no finite number").found(word).allowed("finite numbers");
      if (!point || !next_point)
        throw text.error(line_index, "a word may be two values or an exponent without its letter")
            .found(word)
            .allowed("values with a decimal point each, or an exponent with E")
            .hint("Part the values by a blank");
    }
    values.push_back(*value);
    at += length;
  }
  return true;
}

std::optional<double> unit_in(std::string_view words) {
  std::string w = lower(words);
  for (std::size_t at = w.find("\xC2\xB2"); at != std::string::npos; at = w.find("\xC2\xB2")) w.replace(at, 2, "2");
  w.erase(std::remove_if(w.begin(), w.end(), [](char c) { return c == '^' || c == '*' || c == '(' || c == ')'; }),
          w.end());
  const auto has = [&w](std::string_view part) { return w.find(part) != std::string::npos; };
  if (has("cm/s2") || has("cm/sec2") || has("cm/s/s") || has("cm/sec/sec") || has("cm_s2") || has("cm/s.s"))
    return 0.01;
  // Standard gravity in the words of PEER, COSMOS and of table headers.
  constexpr double kStandardGravity = 9.80665;
  if (has("mm/s2") || has("mm_s2")) return 0.001;
  if (has("m/s2") || has("m/sec2") || has("m/s/s") || has("m/sec/sec") || has("m_s2")) return 1.0;
  for (std::size_t at = w.find("gal"); at != std::string::npos; at = w.find("gal", at + 1)) {
    const bool starts = at == 0 || std::isalpha(static_cast<unsigned char>(w[at - 1])) == 0;
    const std::size_t end = at + (w.compare(at, 4, "gals") == 0 ? 4 : 3);
    if (starts && (end == w.size() || std::isalpha(static_cast<unsigned char>(w[end])) == 0)) return 0.01;
  }
  for (std::size_t at = w.find('g'); at != std::string::npos; at = w.find('g', at + 1)) {
    const auto alone = [&w](std::size_t i) { return std::isalnum(static_cast<unsigned char>(w[i])) == 0; };
    if ((at == 0 || alone(at - 1)) && (at + 1 == w.size() || alone(at + 1))) return kStandardGravity;
  }
  return std::nullopt;
}

double unit_or_refuse(const Text& text, std::size_t line_index, std::optional<double> named,
                      const RecordOptions& options) {
  if (named) return *named;
  if (const auto given = unit_in(options.unit)) return *given;
  throw text.error(line_index, "the record names no unit of acceleration")
      .found(text.lines.empty() ? std::string() : std::string(text.lines[line_index].substr(0, 80)))
      .allowed("g, m/s2 or cm/s2 in the header")
      .hint("Say it with --record-unit g, m/s2 or cm/s2");
}

std::optional<double> number_after(std::string_view line, std::string_view keyword) {
  const std::string low = lower(line), key = lower(keyword);
  const std::size_t at = low.find(key);
  if (at == std::string::npos) return std::nullopt;
  std::size_t i = at + key.size();
  while (i < line.size() && (line[i] == ' ' || line[i] == '\t' || line[i] == '=' || line[i] == ':')) ++i;
  bool point = false;
  const std::size_t length = number_length(line.substr(i), point);
  return length == 0 ? std::nullopt : base::parse_real(line.substr(i, length));
}

std::size_t checked_count(const Text& text, std::size_t line_index, double count) {
  const auto most = static_cast<double>(text.content.size() / 2 + 1);
  if (!(count >= 2.0) || !(count <= most) || count != std::floor(count))
    throw text.error(line_index, "the number of values in the header cannot be right")
        .found(base::to_text(count))
        .allowed("2 to " + base::to_text(most) + ", what the file can hold");
  return static_cast<std::size_t>(count);
}

double checked_step(const Text& text, std::size_t line_index, double dt) {
  constexpr double kLongest = 10.0;  // s
  if (!(dt > 0.0) || !(dt <= kLongest))
    throw text.error(line_index, "the step of the record cannot be right")
        .found(base::to_text(dt) + " s")
        .allowed("above 0, at most 10 s");
  return dt;
}

void name_component(std::string_view component, survey::Accelerogram& record) {
  const std::string word(base::trim(component));
  record.component = word;
  const std::string low = lower(word);
  if (low == "up" || low == "v" || low == "ver" || low == "vert" || low == "vertical" || low == "z" || low == "ud") {
    record.vertical = true;
  } else if (low == "dwn" || low == "down" || low == "dn") {
    record.vertical = true;
    for (double& a : record.acceleration) a = -a;
    record.notes.push_back("The component is positive downwards; its sign was turned.");
  } else if (const auto azimuth = base::parse_real(word); azimuth && *azimuth >= 0.0 && *azimuth <= 360.0) {
    record.azimuth_deg = std::fmod(*azimuth, 360.0);
  }
}

namespace {

Text load(const std::filesystem::path& path) {
  constexpr std::uintmax_t kMost = std::uintmax_t{1} << 30;
  Text text;
  text.name = path.string();
  text.content = base::read_file(path, kMost);
  const std::string_view all = text.content;
  for (std::size_t at = 0; at < all.size();) {
    std::size_t end = all.find('\n', at);
    if (end == std::string_view::npos) end = all.size();
    std::string_view line = all.substr(at, end - at);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    text.lines.push_back(line);
    at = end + 1;
  }
  if (text.lines.empty() || all.find('\0') != std::string_view::npos)
    throw Error(ErrorCode::invalid_input, "no record of ground motion")
        .file(text.name)
        .record("line 1")
        .found(all.empty() ? "an empty file" : "bytes that are no text")
        .allowed("PEER AT2, SMC, COSMOS V2, velocity table, columns of time and acceleration");
  return text;
}

bool contains(const Text& text, std::size_t lines, std::string_view word) {
  for (std::size_t i = 0; i < std::min(lines, text.lines.size()); ++i)
    if (lower(text.lines[i]).find(word) != std::string::npos) return true;
  return false;
}

bool looks_like_smc(const Text& text) {
  if (text.lines.size() < 28) return false;
  for (std::size_t i = 1; i < 11; ++i)
    if (text.lines[i].empty() || text.lines[i][0] != '*') return false;
  return true;
}

bool looks_like_cosmos(const Text& text) {
  return contains(text, text.lines.size() < 200 ? text.lines.size() : 200, "acceleration pts") ||
         contains(text, 200, "points of accel");
}

bool looks_like_velocity(const Text& text) {
  if (contains(text, 1, "velocity points")) return true;
  // A name, then "count,dt", then single numbers.
  if (text.lines.size() < 4) return false;
  const auto comma = text.lines[1].find(',');
  if (comma == std::string_view::npos) return false;
  const auto count = base::parse_integer(text.lines[1].substr(0, comma));
  const auto dt = base::parse_real(text.lines[1].substr(comma + 1));
  return count && dt && base::parse_real(text.lines[2]) && base::parse_real(text.lines[3]) &&
         !base::parse_real(text.lines[0]);
}

std::vector<survey::Accelerogram> read_any(const Text& text, const RecordOptions& options) {
  if (contains(text, 6, "npts")) return read_at2(text, options);
  if (looks_like_smc(text)) return read_smc(text);
  if (looks_like_cosmos(text)) return read_cosmos(text, options);
  if (looks_like_velocity(text)) return read_velocity_table(text);
  return read_columns(text, options);
}

}  // namespace
}  // namespace records

void RecordOptions::visit(base::OptionVisitor& visitor) {
  visitor.choice("record-unit", unit, {"none", "g", "m/s2", "cm/s2"},
                 "Unit of acceleration of records that name none (such records are refused otherwise)");
  visitor.text("record-column", column, "Column of the acceleration in tables with several");
}

std::vector<survey::Accelerogram> read_accelerograms(const std::filesystem::path& path, const RecordOptions& options) {
  const auto text = records::load(path);
  auto list = records::read_any(text, options);
  for (auto& record : list) {
    if (!std::all_of(record.acceleration.begin(), record.acceleration.end(), [](double a) { return std::isfinite(a); }))
      throw base::Error(base::ErrorCode::invalid_input, "an acceleration is too large for a number")
          .file(text.name)
          .record("record " + record.component);
    const std::string stem = path.stem().string();
    record.name = list.size() > 1 && !record.component.empty() ? stem + "_" + record.component : stem;
  }
  return list;
}

}  // namespace cairn::io
