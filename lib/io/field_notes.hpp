// Field notes: what people wrote down at a rock, as a table of their own columns.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cairn::io {

struct FieldNote {
  std::uint64_t line = 0;
  std::string id;                                           // of the rock; "" = joined by position
  std::optional<double> latitude_deg, longitude_deg;        // WGS84; both or none
  std::optional<std::int64_t> observed_ns;                  // UTC, of column observed_utc
  std::vector<std::pair<std::string, std::string>> values;  // all other cells that are not empty, by column, as written
};

struct FieldNotes {
  std::vector<std::string> columns;  // of the values, in file order
  std::vector<FieldNote> notes;      // in file order
};

// A CSV with a header. `id` (or `rock_id`), `latitude_deg` (or `latitude`, `lat`) and `longitude_deg` (or `longitude`,
// `lon`, `lng`) join a note to its rock; `observed_utc` orders the notes of one rock; every other column is kept under
// its name in lower case, blanks as underscores. Throws invalid_input with line and column where a note has neither id
// nor position, a position is off the globe or half there, a time is none, or two columns get one name.
[[nodiscard]] FieldNotes read_field_notes(const std::filesystem::path& path);

}  // namespace cairn::io
