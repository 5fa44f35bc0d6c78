#include "io/movingai.hpp"

#include <cmath>
#include <optional>
#include <string_view>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;

constexpr std::int64_t kMostLines = 1'000'000;  // of a side
constexpr std::string_view kTerrain = ".GSWT@O";

// Lines of a text, with LF or CRLF.
class Lines {
 public:
  Lines(std::string_view text, std::string file) : text_(text), file_(std::move(file)) {}

  [[nodiscard]] bool next() {
    if (at_ >= text_.size()) return false;
    const auto end = std::min(text_.find('\n', at_), text_.size());
    line_ = text_.substr(at_, end - at_);
    if (!line_.empty() && line_.back() == '\r') line_.remove_suffix(1);
    at_ = end + 1;
    ++number_;
    return true;
  }
  // The next line that is not blank; false at the end.
  [[nodiscard]] bool next_filled() {
    while (next())
      if (!base::trim(line_).empty()) return true;
    return false;
  }
  [[nodiscard]] std::string_view line() const { return line_; }
  [[nodiscard]] std::uint64_t number() const { return number_; }
  [[nodiscard]] Error error(std::string message) const {
    return Error(ErrorCode::invalid_input, std::move(message)).file(file_).record("line " + std::to_string(number_));
  }

 private:
  std::string_view text_, line_;
  std::string file_;
  std::size_t at_ = 0;
  std::uint64_t number_ = 0;
};

std::vector<std::string_view> words(std::string_view line) {
  std::vector<std::string_view> found;
  constexpr std::string_view kBlanks = " \t";
  for (std::size_t at = line.find_first_not_of(kBlanks); at != std::string_view::npos;) {
    const auto end = std::min(line.find_first_of(kBlanks, at), line.size());
    found.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(kBlanks, end);
  }
  return found;
}

std::string shown(std::string_view text) {
  constexpr std::size_t kMost = 40;
  std::string out = "'";
  for (const char c : text.substr(0, kMost)) out += c >= ' ' && c <= '~' ? c : '?';
  return out + (text.size() > kMost ? "...'" : "'");
}

std::int64_t side(const Lines& lines, std::string_view name, std::string_view value) {
  const auto number = base::parse_integer(value);
  if (!number || *number < 1 || *number > kMostLines)
    throw lines.error("the map's " + std::string(name) + " is no size")
        .found(shown(value))
        .allowed("1 to " + std::to_string(kMostLines));
  return *number;
}

}  // namespace

bool is_free_terrain(char terrain) {
  return terrain == '.' || terrain == 'G' || terrain == 'S';
}

geometry::Grid<char> read_octile_map(const std::filesystem::path& path) {
  const std::string text = base::read_file(path);
  Lines lines(text, path.string());
  std::optional<std::int64_t> height, width;
  bool typed = false, body = false;
  while (!body) {
    if (!lines.next_filled()) throw lines.error("the map's header ends before its line 'map'");
    const auto fields = words(lines.line());
    if (fields.size() == 1 && fields[0] == "map") {
      body = true;
    } else if (fields.size() == 2 && fields[0] == "type") {
      if (fields[1] != "octile") throw lines.error("not an octile map").found(shown(fields[1])).allowed("octile");
      typed = true;
    } else if (fields.size() == 2 && fields[0] == "height") {
      height = side(lines, "height", fields[1]);
    } else if (fields.size() == 2 && fields[0] == "width") {
      width = side(lines, "width", fields[1]);
    } else {
      throw lines.error("not a header line of a Moving AI map")
          .found(shown(lines.line()))
          .allowed("type octile, height N, width N, map");
    }
  }
  if (!typed || !height || !width) throw lines.error("the map's header lacks type, height or width");
  if (static_cast<std::uint64_t>(*height) * static_cast<std::uint64_t>(*width) > text.size())
    throw lines.error("the file is shorter than the map it declares")
        .found(std::to_string(text.size()) + " bytes")
        .allowed("at least " + std::to_string(*height) + " lines of " + std::to_string(*width));
  const auto rows = static_cast<std::size_t>(*height), columns = static_cast<std::size_t>(*width);
  geometry::Grid<char> map({0.0, static_cast<double>(rows), 1.0, columns, rows}, '@');
  for (std::size_t r = 0; r < rows; ++r) {
    if (!lines.next())
      throw lines.error("the map ends too early").found(std::to_string(r) + " rows").allowed(std::to_string(rows));
    if (lines.line().size() != columns)
      throw lines.error("a row of the map has another length than its width")
          .found(std::to_string(lines.line().size()))
          .allowed(std::to_string(columns));
    for (std::size_t c = 0; c < columns; ++c) {
      const char terrain = lines.line()[c];
      if (kTerrain.find(terrain) == std::string_view::npos)
        throw lines.error("unknown terrain at column " + std::to_string(c + 1))
            .found(shown(lines.line().substr(c, 1)))
            .allowed(". G S W T @ O");
      map.at(r, c) = terrain;
    }
  }
  if (lines.next_filled()) throw lines.error("the map goes on after its last row").found(shown(lines.line()));
  return map;
}

std::vector<ScenarioQuery> read_scenario(const std::filesystem::path& path, std::size_t rows, std::size_t columns) {
  const std::string text = base::read_file(path);
  Lines lines(text, path.string());
  const auto version = lines.next_filled() ? words(lines.line()) : std::vector<std::string_view>{};
  const auto number = version.size() == 2 && version[0] == "version" ? base::parse_real(version[1]) : std::nullopt;
  if (!number || *number != 1.0)
    throw lines.error("not a scenario of version 1").found(shown(lines.line())).allowed("version 1");
  std::vector<ScenarioQuery> queries;
  while (lines.next_filled()) {
    // bucket, map, width, height, start x, start y, goal x, goal y, length; the map's name may hold blanks.
    const auto fields = words(lines.line());
    constexpr std::size_t kFields = 9;
    if (fields.size() < kFields)
      throw lines.error("a query has nine fields").found(std::to_string(fields.size())).allowed("9");
    const auto whole = [&](std::string_view name, std::size_t from_end, std::int64_t most) {
      const std::string_view field = fields[fields.size() - from_end];
      const auto value = base::parse_integer(field);
      if (!value || *value < 0 || *value > most)
        throw lines.error("bad " + std::string(name) + " of a query")
            .found(shown(field))
            .allowed("0 to " + std::to_string(most));
      return static_cast<std::size_t>(*value);
    };
    const auto bucket = base::parse_integer(fields[0]);
    if (!bucket || *bucket < 0)
      throw lines.error("bad bucket of a query").found(shown(fields[0])).allowed("0 and more");
    const std::size_t width = whole("map width", 7, kMostLines), height = whole("map height", 6, kMostLines);
    if (width != columns || height != rows)
      throw lines.error("a query is of a map of another size")
          .found(std::to_string(width) + " x " + std::to_string(height))
          .allowed(std::to_string(columns) + " x " + std::to_string(rows))
          .hint("Give the scenario that belongs to the map; maps are not scaled");
    const auto last_column = static_cast<std::int64_t>(columns) - 1, last_row = static_cast<std::int64_t>(rows) - 1;
    ScenarioQuery query;
    query.line = lines.number();
    query.bucket = *bucket;
    query.start.second = whole("start x", 5, last_column);
    query.start.first = whole("start y", 4, last_row);
    query.goal.second = whole("goal x", 3, last_column);
    query.goal.first = whole("goal y", 2, last_row);
    const auto optimal = base::parse_real(fields.back());
    if (!optimal || !std::isfinite(*optimal) || *optimal < 0.0)
      throw lines.error("bad length of a query").found(shown(fields.back())).allowed("0 and more");
    query.optimal = *optimal;
    queries.push_back(query);
  }
  return queries;
}

}  // namespace cairn::io
