#include "io/edits_csv.hpp"

#include <array>
#include <string>

#include "base/number_text.hpp"
#include "base/time.hpp"
#include "io/csv.hpp"

namespace cairn::io {
namespace {

constexpr std::array<std::string_view, 6> kColumns{"rock_id", "action", "value", "reason", "operator", "time"};

// Digits only, so that blanks and signs are no part of a time.
std::optional<int> digits(std::string_view text) {
  if (text.empty() || text.size() > 4) return std::nullopt;
  int value = 0;
  for (const char c : text) {
    if (c < '0' || c > '9') return std::nullopt;
    value = 10 * value + (c - '0');
  }
  return value;
}

bool needs_value(survey::EditAction action) {
  using survey::EditAction;
  return action != EditAction::accept && action != EditAction::reject;
}

}  // namespace

std::optional<std::int64_t> parse_utc_ns(std::string_view text) {
  constexpr std::int64_t kMinute_ns = 60'000'000'000;
  if (text.size() < 10 || text[4] != '-' || text[7] != '-') return std::nullopt;
  const auto year = digits(text.substr(0, 4)), month = digits(text.substr(5, 2)), day = digits(text.substr(8, 2));
  if (!year || !month || !day) return std::nullopt;
  if (text.size() == 10) return base::civil_to_ns(*year, *month, *day, 0, 0, 0.0);
  if (text.size() < 16 || (text[10] != 'T' && text[10] != ' ') || text[13] != ':') return std::nullopt;
  const auto hour = digits(text.substr(11, 2)), minute = digits(text.substr(14, 2));
  if (!hour || !minute) return std::nullopt;
  std::string_view rest = text.substr(16);
  std::int64_t offset_ns = 0;
  if (!rest.empty() && rest.back() == 'Z') {
    rest.remove_suffix(1);
  } else if (rest.size() >= 6 && rest[rest.size() - 3] == ':' &&
             (rest[rest.size() - 6] == '+' || rest[rest.size() - 6] == '-')) {
    const auto zone = rest.substr(rest.size() - 6);
    const auto hours = digits(zone.substr(1, 2)), minutes = digits(zone.substr(4, 2));
    if (!hours || !minutes || *hours > 14 || *minutes > 59) return std::nullopt;
    offset_ns = (60 * *hours + *minutes) * kMinute_ns * (zone[0] == '+' ? 1 : -1);
    rest.remove_suffix(6);
  }
  double second = 0.0;
  if (!rest.empty()) {
    if (rest.size() < 3 || rest[0] != ':' || !digits(rest.substr(1, 2))) return std::nullopt;
    const auto value = base::parse_real(rest.substr(1));
    if (!value || rest.find_first_not_of("0123456789.", 1) != std::string_view::npos) return std::nullopt;
    second = *value;
  }
  const auto ns = base::civil_to_ns(*year, *month, *day, *hour, *minute, second);
  if (!ns) return std::nullopt;
  return *ns - offset_ns;
}

std::vector<survey::Edit> read_edits(const std::filesystem::path& path) {
  CsvReader csv(path);
  std::array<std::size_t, kColumns.size()> column{};
  for (std::size_t i = 0; i < kColumns.size(); ++i) column[i] = csv.column(kColumns[i]);
  if (csv.header().size() != kColumns.size())
    throw base::Error(base::ErrorCode::invalid_input, "edits.csv has columns that are not known")
        .file(path.string())
        .found(std::to_string(csv.header().size()) + " columns")
        .allowed("rock_id,action,value,reason,operator,time");
  std::vector<survey::Edit> edits;
  while (csv.next()) {
    survey::Edit edit;
    edit.line = csv.line();
    edit.rock_id = base::trim(csv.required(column[0]));
    const auto action = survey::edit_action_from(base::trim(csv.required(column[1])));
    if (!action)
      throw csv.error(column[1], "unknown action").allowed("accept, reject, merge, split, reclassify, set, note");
    edit.action = *action;
    edit.value = base::trim(csv.text(column[2]));
    if (edit.value.empty() && needs_value(edit.action))
      throw csv.error(column[2], "the action '" + std::string(survey::name_of(edit.action)) + "' needs a value")
          .allowed(edit.action == survey::EditAction::merge        ? "ids of the rocks to merge into this one: 7;12"
                   : edit.action == survey::EditAction::split      ? "a seed for each part: east,north;east,north [m]"
                   : edit.action == survey::EditAction::reclassify ? "a class or judgement: boulder, precarious, ..."
                   : edit.action == survey::EditAction::set        ? "key=value"
                                                                   : "a text");
    edit.reason = base::trim(csv.text(column[3]));
    edit.reviewer = base::trim(csv.required(column[4]));
    edit.time = base::trim(csv.required(column[5]));
    const auto time = parse_utc_ns(edit.time);
    if (!time) throw csv.error(column[5], "not a time").allowed("ISO 8601, UTC: 2026-05-01T10:20:30Z");
    edit.time_ns = *time;
    if (!edits.empty() && edit.time_ns < edits.back().time_ns)
      throw csv.error(column[5], "earlier than the decision before it: rows are appended, in order of time")
          .allowed(edits.back().time + " or later")
          .hint("Append the decision with the time it was taken; never sort or insert rows");
    edits.push_back(std::move(edit));
  }
  return edits;
}

void write_edits(const std::filesystem::path& path, const std::vector<survey::Edit>& edits) {
  CsvWriter csv(path, kColumns);
  for (const auto& e : edits) {
    csv.cell(e.rock_id).cell(survey::name_of(e.action)).cell(e.value).cell(e.reason).cell(e.reviewer).cell(e.time);
    csv.end_row();
  }
  csv.finish();
}

}  // namespace cairn::io
