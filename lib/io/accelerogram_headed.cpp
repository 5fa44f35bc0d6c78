// PEER AT2, SMC and COSMOS: a header, then values in fixed-width columns.
#include <algorithm>
#include <cmath>

#include "base/number_text.hpp"
#include "io/accelerogram_text.hpp"

namespace cairn::io::records {
namespace {

using survey::Accelerogram;

// `count` values from line `first` on; throws where the file ends before. Returns the line behind.
std::size_t read_body(const Text& text, std::size_t first, std::size_t count, std::size_t header_line,
                      Accelerogram& record, bool cut_allowed) {
  record.acceleration.reserve(count);
  std::size_t line = first;
  bool all = true;
  for (; line < text.lines.size() && record.acceleration.size() < count; ++line)
    all = append_numbers(text, line, count, record.acceleration) && all;
  if (record.acceleration.size() < count)
    throw text.error(header_line, "the record ends early")
        .found(std::to_string(record.acceleration.size()) + " values")
        .allowed(std::to_string(count) + ", as the header says");
  if (cut_allowed) {
    const bool more = !all || std::any_of(text.lines.begin() + static_cast<std::ptrdiff_t>(line), text.lines.end(),
                                          [](std::string_view l) { return !base::trim(l).empty(); });
    if (more) record.notes.push_back("Values beyond the count in the header were cut.");
  }
  return line;
}

void scale(Accelerogram& record, double unit) {
  for (double& a : record.acceleration) a *= unit;
}

std::vector<std::string> split(std::string_view line, char separator) {
  std::vector<std::string> parts;
  for (std::size_t at = 0; at <= line.size();) {
    std::size_t end = line.find(separator, at);
    if (end == std::string_view::npos) end = line.size();
    parts.emplace_back(base::trim(line.substr(at, end - at)));
    at = end + 1;
  }
  return parts;
}

}  // namespace

std::vector<Accelerogram> read_at2(const Text& text, const RecordOptions& options) {
  std::size_t header = 0;
  while (lower(text.lines[header]).find("npts") == std::string::npos) ++header;
  if (header == 0) throw text.error(0, "an AT2 record needs its title, event and unit lines above NPTS");
  Accelerogram record;
  record.format = "peer_at2";
  const std::string units = lower(text.lines[header - 1]);
  for (const std::string_view other : {"velocity", "displacement"})
    if (units.find(other) != std::string::npos)
      throw text.error(header - 1, "the file holds " + std::string(other) + ", not acceleration")
          .allowed("ACCELERATION TIME SERIES IN UNITS OF G")
          .hint("Give the .AT2 file of the record");
  const double unit = unit_or_refuse(text, header - 1, unit_in(units), options);
  // "NPTS= 16396, DT= 0.005 SEC", or the older "16396 0.005 NPTS, DT".
  auto count = number_after(text.lines[header], "npts"), dt = number_after(text.lines[header], "dt");
  if (!count || !dt) {
    std::vector<double> leading;
    const std::string_view all = text.lines[header];
    const std::string_view words = all.substr(0, lower(all).find("npts"));
    for (const auto& word : split(words, ' '))
      if (const auto value = base::parse_real(word); !word.empty() && value) leading.push_back(*value);
    if (leading.size() == 2) {
      count = leading[0];
      dt = leading[1];
    }
  }
  if (!count || !dt)
    throw text.error(header, "the record does not say its number of values and its step")
        .found(std::string(text.lines[header].substr(0, 80)))
        .allowed("NPTS= n, DT= x SEC");
  const std::size_t n = checked_count(text, header, *count);
  record.dt_s = checked_step(text, header, *dt);
  read_body(text, header + 1, n, header, record, true);
  scale(record, unit);
  if (header >= 2) {
    const auto parts = split(text.lines[header - 2], ',');
    record.event = parts.front();
    if (parts.size() >= 3) record.station = parts[parts.size() - 2];
    if (parts.size() >= 2) name_component(parts.back(), record);
  }
  return {record};
}

std::vector<Accelerogram> read_smc(const Text& text) {
  constexpr std::size_t kTextLines = 11, kIntegerLines = 6, kRealLines = 10;
  constexpr double kAbsent = 1.0e38;  // 0.17E+39 stands for "none"
  std::vector<double> integers, reals;
  for (std::size_t i = 0; i < kIntegerLines; ++i) append_numbers(text, kTextLines + i, 48, integers);
  for (std::size_t i = 0; i < kRealLines; ++i) append_numbers(text, kTextLines + kIntegerLines + i, 50, reals);
  if (integers.size() < 48 || reals.size() < 50)
    throw text.error(kTextLines, "the header of the SMC record is not complete")
        .found(std::to_string(integers.size()) + " integers, " + std::to_string(reals.size()) + " reals")
        .allowed("48 integers and 50 reals");
  const std::string kind = lower(text.lines[0]);
  for (const std::string_view other : {"velocity", "displacement"})
    if (kind.find(other) != std::string::npos)
      throw text.error(0, "the file holds " + std::string(other) + ", not acceleration");
  Accelerogram record;
  record.format = "smc";
  constexpr std::size_t kIntegersAt = kTextLines, kRealsAt = kTextLines + kIntegerLines;
  const double comments = std::max(integers[15], 0.0);
  const std::size_t n = checked_count(text, kIntegersAt + 2, integers[16]);
  if (!(reals[1] > 0.0) || reals[1] > kAbsent)
    throw text.error(kRealsAt, "the SMC record does not say its samples a second").found(base::to_text(reals[1]));
  record.dt_s = checked_step(text, kRealsAt, 1.0 / reals[1]);
  if (comments > static_cast<double>(text.lines.size()))
    throw text.error(kIntegersAt + 1, "the SMC record says more comment lines than it has")
        .found(base::to_text(comments));
  const std::size_t body = kTextLines + kIntegerLines + kRealLines + static_cast<std::size_t>(comments);
  for (std::size_t i = body - static_cast<std::size_t>(comments); i < body && i < text.lines.size(); ++i)
    if (lower(text.lines[i]).find("units of g") != std::string::npos)
      record.notes.push_back("A comment speaks of g; SMC values are cm/s^2 by definition and were read so.");
  read_body(text, body, n, kIntegersAt + 2, record, false);
  constexpr double kCentimetre = 0.01;
  scale(record, kCentimetre);
  return {record};
}

std::vector<Accelerogram> read_cosmos(const Text& text, const RecordOptions& options) {
  std::vector<Accelerogram> list;
  std::string station, component;
  std::optional<double> header_dt;
  for (std::size_t i = 0; i < text.lines.size(); ++i) {
    const std::string low = lower(text.lines[i]);
    if (low.rfind("station", 0) == 0) station = base::trim(text.lines[i].substr(7));
    if (const auto at = low.find("comp"); low.rfind("chan", 0) == 0 || low.rfind("sta chan", 0) == 0) {
      if (at != std::string::npos) {
        const auto words = split(text.lines[i].substr(at), ' ');
        for (std::size_t w = 1; w < words.size() && component.empty(); ++w) component = words[w];
      }
      for (const auto& word : split(text.lines[i], ' '))
        if (component.empty() && (lower(word) == "up" || base::parse_integer(word).value_or(-1) > 0) &&
            at == std::string::npos)
          component = word;
    }
    if (const auto at = low.find("samples/sec"); at != std::string::npos) {
      const auto words = split(text.lines[i].substr(0, at), ' ');
      for (auto w = words.rbegin(); w != words.rend(); ++w)
        if (const auto rate = base::parse_real(*w); !w->empty() && rate && *rate > 0.0) {
          header_dt = 1.0 / *rate;
          break;
        }
    }
    const bool block =
        low.find("acceleration pts") != std::string::npos || low.find("points of accel") != std::string::npos;
    if (!block) continue;
    Accelerogram record;
    record.format = "cosmos";
    record.station = station;
    std::optional<double> count;
    for (const auto& word : split(text.lines[i], ' '))
      if (const auto value = base::parse_real(word); !word.empty() && value) {
        count = *value;
        break;
      }
    if (!count) throw text.error(i, "the block of acceleration does not say its number of values");
    const std::size_t n = checked_count(text, i, *count);
    auto dt = number_after(low, "spaced at");
    if (!dt) dt = number_after(low, "pts, at");
    if (!dt) dt = header_dt;
    if (!dt)
      throw text.error(i, "the record does not say its step")
          .found(std::string(text.lines[i].substr(0, 80)))
          .allowed("\"equally spaced at x sec\", or \"n samples/sec\" in the header");
    record.dt_s = checked_step(text, i, *dt);
    const std::size_t units_at = std::min(low.find("unit"), low.find(" in "));
    const double unit = unit_or_refuse(
        text, i, units_at == std::string::npos ? std::nullopt : unit_in(std::string_view(low).substr(units_at)),
        options);
    i = read_body(text, i + 1, n, i, record, false) - 1;
    scale(record, unit);
    name_component(component, record);
    component.clear();
    list.push_back(std::move(record));
  }
  return list;
}

}  // namespace cairn::io::records
