// edits.csv: the reviewer's decisions, append-only.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "survey/edit.hpp"

namespace cairn::io {

// "2026-05-01T10:20:30Z", seconds and their fraction may be absent, "Z" or an offset "+02:00" may be absent (UTC then);
// a date alone is its midnight. Empty where the text is something else.
[[nodiscard]] std::optional<std::int64_t> parse_utc_ns(std::string_view text);

// Columns rock_id,action,value,reason,operator,time (others are refused: a misspelt column would be lost silently).
// Throws invalid_input with line and column for an unknown action, an empty rock_id or operator, a time that is none,
// a time earlier than the row's before (rows are appended, never sorted in), a value that its action needs and does not
// have.
[[nodiscard]] std::vector<survey::Edit> read_edits(const std::filesystem::path& path);

// Written straight to `path`; reads back equal.
void write_edits(const std::filesystem::path& path, const std::vector<survey::Edit>& edits);

}  // namespace cairn::io
