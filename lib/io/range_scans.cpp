#include "io/range_scans.hpp"

#include <charconv>
#include <cmath>
#include <limits>
#include <string>

#include "base/angle.hpp"
#include "base/number_text.hpp"
#include "io/csv.hpp"

namespace cairn::io {
namespace {

// Ranges are floats: the shortest text that reads back as the same float.
void append(std::string& text, float value) {
  if (!text.empty()) text += ' ';
  if (std::isnan(value)) {
    text += "nan";
  } else if (std::isinf(value)) {
    text += value > 0.0F ? "inf" : "-inf";
  } else {
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof(digits), value);
    text.append(digits, end.ptr);
  }
}

std::vector<float> ranges_of(const CsvReader& csv, std::size_t column) {
  std::vector<float> ranges;
  const std::string_view text = csv.text(column);
  for (std::size_t begin = 0; begin < text.size();) {
    if (text[begin] == ' ') {
      ++begin;
      continue;
    }
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::string_view word = text.substr(begin, end - begin);
    const auto value = base::parse_real(word);
    if (!value || (std::isfinite(*value) && std::abs(*value) > 1e9))
      throw csv.error(column, "a range that is no number")
          .found("'" + std::string(word.substr(0, 40)) + "' after " + std::to_string(ranges.size()) + " ranges")
          .allowed("metres, inf, -inf or nan, separated by blanks");
    ranges.push_back(static_cast<float>(*value));
    begin = end;
  }
  return ranges;
}

}  // namespace

std::vector<survey::RangeScan> read_range_scans(const std::filesystem::path& path) {
  CsvReader csv(path);
  const auto time = csv.column("time_ns"), increment = csv.column("time_increment_ns"),
             angle = csv.column("angle_min_deg"), step = csv.column("angle_increment_deg"),
             least = csv.column("range_min_m"), most = csv.column("range_max_m"), ranges = csv.column("ranges_m");
  std::vector<survey::RangeScan> scans;
  while (csv.next()) {
    survey::RangeScan scan;
    scan.time_ns = csv.integer(time);
    scan.time_increment_ns = csv.integer(increment, 0, std::numeric_limits<std::int32_t>::max());
    scan.angle_min = base::deg_to_rad(csv.real(angle));
    scan.angle_increment = base::deg_to_rad(csv.real(step));
    scan.range_min_m = csv.real(least);
    scan.range_max_m = csv.real(most);
    if (scan.angle_increment == 0.0) throw csv.error(step, "rays that all go one way").allowed("not 0");
    if (scan.range_min_m < 0.0) throw csv.error(least, "a negative range limit").allowed("0 or more");
    if (!(scan.range_max_m > scan.range_min_m))
      throw csv.error(most, "range limits that do not ascend").allowed("more than range_min_m");
    if (!scans.empty() && scan.time_ns <= scans.back().time_ns)
      throw csv.error(time, "times that do not ascend").allowed("more than " + std::to_string(scans.back().time_ns));
    scan.ranges = ranges_of(csv, ranges);
    scans.push_back(std::move(scan));
  }
  return scans;
}

void write_range_scans(const std::filesystem::path& path, std::span<const survey::RangeScan> scans) {
  CsvWriter csv(path, {"time_ns", "time_increment_ns", "angle_min_deg", "angle_increment_deg", "range_min_m",
                       "range_max_m", "ranges_m"});
  for (const auto& scan : scans) {
    for (const double value : {scan.angle_min, scan.angle_increment, scan.range_min_m, scan.range_max_m})
      if (!std::isfinite(value))
        throw base::Error(base::ErrorCode::invalid_argument, "a scan with a limit that is not finite")
            .file(path.string())
            .record("scan at " + std::to_string(scan.time_ns) + " ns");
    std::string ranges;
    for (const float range : scan.ranges) append(ranges, range);
    csv.cell(scan.time_ns)
        .cell(scan.time_increment_ns)
        .cell(base::rad_to_deg(scan.angle_min))
        .cell(base::rad_to_deg(scan.angle_increment))
        .cell(scan.range_min_m)
        .cell(scan.range_max_m);
    csv.cell(std::string_view(ranges));
    csv.end_row();
  }
  csv.finish();
}

}  // namespace cairn::io
