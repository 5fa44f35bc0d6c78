// A reviewer's decision about a rock, as it stands in edits.csv. Decisions take precedence over the automatic result.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace cairn::survey {

// accept: the rock counts, whatever the automatic result said; reject: it does not; merge: the rocks named in `value`
// are parts of this one; split: `value` holds a seed for each part; reclassify: class or judgement; set: key=value;
// note: free text.
enum class EditAction { accept, reject, merge, split, reclassify, set, note };

[[nodiscard]] std::string_view name_of(EditAction action);
[[nodiscard]] std::optional<EditAction> edit_action_from(std::string_view name);

struct Edit {
  std::uint64_t line = 0;  // of edits.csv, for messages
  std::string rock_id;     // of the result, or of an inventory made from it; aliases are followed
  EditAction action = EditAction::note;
  std::string value;
  std::string reason;
  std::string reviewer;      // column `operator`
  std::string time;          // ISO 8601, UTC, as written
  std::int64_t time_ns = 0;  // the same, UTC

  friend bool operator==(const Edit& a, const Edit& b) {
    return a.rock_id == b.rock_id && a.action == b.action && a.value == b.value && a.reason == b.reason &&
           a.reviewer == b.reviewer && a.time_ns == b.time_ns;
  }
};

}  // namespace cairn::survey
