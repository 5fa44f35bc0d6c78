// What the readers of records share: lines, numbers that run together, units. Internal to io.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "io/accelerogram.hpp"

namespace cairn::io::records {

// A file by lines; numbers of lines count from 1.
struct Text {
  std::string name;
  std::string content;
  std::vector<std::string_view> lines;  // without line ends

  [[nodiscard]] base::Error error(std::size_t line_index, std::string message) const;
};

// Appends the numbers of a line; throws with the line for a word that is none, or that may be two or one
// ("1.2-3": an exponent without its letter?). At most `limit` numbers in all; returns false where some were left.
bool append_numbers(const Text& text, std::size_t line_index, std::size_t limit, std::vector<double>& values);

// m/s^2 of one unit, from "g", "UNITS OF G", "cm/s2", "cm/sec/sec", "gal", "m/s^2", ..; nothing where none is named.
[[nodiscard]] std::optional<double> unit_in(std::string_view words);
// The unit of options, or the error that none is named.
[[nodiscard]] double unit_or_refuse(const Text& text, std::size_t line_index, std::optional<double> named,
                                    const RecordOptions& options);

// The number behind a keyword ("DT=", "NPTS"), case-insensitive, blanks and '=' or ':' between.
[[nodiscard]] std::optional<double> number_after(std::string_view line, std::string_view keyword);
[[nodiscard]] std::string lower(std::string_view text);

// A count from a header, checked against what the file can hold (two bytes a value at least).
[[nodiscard]] std::size_t checked_count(const Text& text, std::size_t line_index, double count);
[[nodiscard]] double checked_step(const Text& text, std::size_t line_index, double dt);

// Direction and sign from a component's name: "090", "N45E" stays unnamed, "UP", "DWN", "V".
void name_component(std::string_view component, survey::Accelerogram& record);

[[nodiscard]] std::vector<survey::Accelerogram> read_at2(const Text& text, const RecordOptions& options);
[[nodiscard]] std::vector<survey::Accelerogram> read_smc(const Text& text);
[[nodiscard]] std::vector<survey::Accelerogram> read_cosmos(const Text& text, const RecordOptions& options);
[[nodiscard]] std::vector<survey::Accelerogram> read_velocity_table(const Text& text);
[[nodiscard]] std::vector<survey::Accelerogram> read_columns(const Text& text, const RecordOptions& options);

}  // namespace cairn::io::records
