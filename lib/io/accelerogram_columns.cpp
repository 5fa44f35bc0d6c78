// Velocity tables of the shake robot, and tables of time and acceleration.
#include <algorithm>
#include <cmath>

#include "base/number_text.hpp"
#include "io/accelerogram_text.hpp"

namespace cairn::io::records {
namespace {

using survey::Accelerogram;

std::vector<std::string> cells(std::string_view line, char separator) {
  std::vector<std::string> out;
  if (separator == ' ') {
    std::size_t at = 0;
    while ((at = line.find_first_not_of(" \t", at)) != std::string_view::npos) {
      std::size_t end = line.find_first_of(" \t", at);
      if (end == std::string_view::npos) end = line.size();
      out.emplace_back(line.substr(at, end - at));
      at = end;
    }
    return out;
  }
  for (std::size_t at = 0; at <= line.size();) {
    std::size_t end = line.find(separator, at);
    if (end == std::string_view::npos) end = line.size();
    out.emplace_back(base::trim(line.substr(at, end - at)));
    at = end + 1;
  }
  while (!out.empty() && out.back().empty()) out.pop_back();
  return out;
}

bool numeric(const std::vector<std::string>& row) {
  return !row.empty() &&
         std::all_of(row.begin(), row.end(), [](const std::string& c) { return base::parse_real(c).has_value(); });
}

double finite_cell(const Text& text, std::size_t line, const std::string& cell) {
  const auto value = base::parse_real(cell);
  if (!value || !std::isfinite(*value))
    throw text.error(line, "a value of the record is no finite number")
        .found(cell)
        .allowed("one finite number a column")
        .hint("Values that run together must be parted by a separator");
  return *value;
}

std::size_t acceleration_column(const Text& text, std::size_t line, const std::vector<std::string>& header,
                                std::size_t columns, const RecordOptions& options) {
  const auto names = [&header] {
    std::string all;
    for (const auto& name : header) all += (all.empty() ? "" : ", ") + name;
    return all;
  };
  if (!options.column.empty()) {
    for (std::size_t k = 0; k < header.size(); ++k)
      if (header[k] == options.column) return k;
    throw text.error(line, "there is no such column")
        .found(options.column)
        .allowed(header.empty() ? "no header" : names());
  }
  std::vector<std::size_t> found;
  for (std::size_t k = 1; k < header.size(); ++k)
    if (lower(header[k]).find("acc") != std::string::npos) found.push_back(k);
  if (found.size() == 1) return found[0];
  if (columns == 2) return 1;
  throw text.error(line, "it is not clear which column holds the acceleration")
      .found(header.empty() ? std::to_string(columns) + " columns without a header" : names())
      .allowed("two columns, or one whose header says acceleration")
      .hint("Name it with --record-column");
}

}  // namespace

std::vector<Accelerogram> read_velocity_table(const Text& text) {
  const bool one_line = lower(text.lines[0]).find("velocity points") != std::string::npos;
  std::optional<double> count, dt;
  const std::size_t header = one_line ? 0 : 1;
  Accelerogram record;
  record.format = "velocity_table";
  if (one_line) {
    count = number_after(text.lines[0], "velocity points");
    dt = number_after(text.lines[0], "dt");
  } else {
    record.event = base::trim(text.lines[0]);
    const auto parts = cells(text.lines[1], ',');
    count = base::parse_real(parts[0]);
    dt = base::parse_real(parts[1]);
  }
  if (!count || !dt)
    throw text.error(header, "the velocity table does not say its number of values and its step")
        .found(std::string(text.lines[header].substr(0, 80)));
  const std::size_t n = checked_count(text, header, *count);
  record.dt_s = checked_step(text, header, *dt);
  std::vector<double> velocity;
  velocity.reserve(n);
  bool cut = false;
  for (std::size_t i = header + 1; i < text.lines.size() && !cut; ++i) {
    const std::string_view word = base::trim(text.lines[i]);
    if (word.empty()) continue;
    if (velocity.size() == n) cut = true;
    else velocity.push_back(finite_cell(text, i, std::string(word)));
  }
  if (velocity.size() < n)
    throw text.error(header, "the record ends early")
        .found(std::to_string(velocity.size()) + " values")
        .allowed(std::to_string(n) + ", as the header says");
  if (cut) record.notes.push_back("Values beyond the count in the header were cut.");
  // Difference quotients stand at the middles of the steps; the whole record moves by half a step. Zeros at both ends
  // keep the velocities of the table at its first and last value.
  record.acceleration.push_back(0.0);
  for (std::size_t i = 0; i + 1 < velocity.size(); ++i)
    record.acceleration.push_back((velocity[i + 1] - velocity[i]) / record.dt_s);
  record.acceleration.push_back(0.0);
  if (velocity.size() < 3) throw text.error(header, "a record needs three velocities at least");
  record.notes.push_back("Acceleration is the difference quotient of the velocities given in m/s.");
  return {record};
}

std::vector<Accelerogram> read_columns(const Text& text, const RecordOptions& options) {
  Accelerogram record;
  record.format = "columns";
  char separator = ' ';
  std::size_t first = 0;
  // Lines of words above the first row of numbers; the last of them is the header.
  std::size_t header_line = 0;
  std::vector<std::string> header;
  std::string words;
  for (; first < text.lines.size(); ++first) {
    std::string_view line = text.lines[first];
    if (first == 0 && line.size() >= 3 && line.substr(0, 3) == "\xEF\xBB\xBF") line.remove_prefix(3);
    if (base::trim(line).empty()) continue;
    for (const char c : {';', ',', '\t', ' '}) {
      separator = c;
      if (line.find(c) != std::string_view::npos) break;
    }
    auto row = cells(line, separator);
    if (numeric(row)) break;
    header = std::move(row);
    header_line = first;
    words += ' ';
    words += line;
  }
  if (first >= text.lines.size()) throw text.error(0, "the table of the record holds no row of numbers");
  // Rows may be parted otherwise than the header: by tabs under a header with blanks.
  std::string_view first_row = text.lines[first];
  const std::size_t columns = cells(first_row, separator).size();
  if (columns < 2)
    throw text.error(first, "a single column has no times, so its step is not known")
        .found(std::string(first_row.substr(0, 80)))
        .allowed("time and acceleration");
  if (header.size() != columns) header.clear();
  const std::size_t column = acceleration_column(text, header_line, header, columns, options);
  const std::string unit_words = header.empty() ? words : header[column];
  const double unit = unit_or_refuse(text, header_line, unit_in(unit_words), options);
  std::vector<double> times;
  std::vector<std::size_t> lines;
  for (std::size_t i = first; i < text.lines.size(); ++i) {
    if (base::trim(text.lines[i]).empty()) continue;
    const auto row = cells(text.lines[i], separator);
    if (row.size() != columns)
      throw text.error(i, "the row has another number of columns")
          .found(std::to_string(row.size()))
          .allowed(std::to_string(columns))
          .hint("Values that run together must be parted by a separator");
    times.push_back(finite_cell(text, i, row[0]));
    record.acceleration.push_back(unit * finite_cell(text, i, row[column]));
    lines.push_back(i);
  }
  if (times.size() < 3) throw text.error(first, "a record needs three rows at least");
  const double dt = (times.back() - times.front()) / static_cast<double>(times.size() - 1);
  record.dt_s = checked_step(text, first, dt);
  constexpr double kUneven = 0.1;  // of a step: times rounded to few decimals pass, a missing row does not
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double expected = times.front() + dt * static_cast<double>(i);
    const bool backwards = i > 0 && times[i] <= times[i - 1];
    if (std::abs(times[i] - expected) > kUneven * dt || backwards)
      throw text.error(lines[i], "the step of the record is not constant")
          .found("time " + base::to_text(times[i]) + " s")
          .allowed(base::to_text(expected) + " s for an even step of " + base::to_text(dt) + " s")
          .hint("Resample the record to a constant step");
  }
  if (!header.empty()) record.component = header[column];
  return {record};
}

}  // namespace cairn::io::records
