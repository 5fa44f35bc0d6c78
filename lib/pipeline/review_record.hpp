// review.json: which decisions were applied to a result, and what they made of each rock.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "survey/edit.hpp"

namespace cairn::pipeline {

// What review says about one rock beside its record in rocks.json.
struct ReviewedRock {
  std::string judgement;  // precarious, semi_precarious, not_precarious; "" = none given
  // Of the last decision.
  std::string reviewer, time, reason;
  std::vector<std::string> notes;                           // in order
  std::vector<std::pair<std::string, std::string>> fields;  // of "set", by field, the last of each
};

struct ReviewRecord {
  std::vector<survey::Edit> edits;               // all that were applied, in order
  std::map<std::int64_t, ReviewedRock> rocks;    // by id
  std::map<std::int64_t, std::int64_t> aliases;  // merged id -> id that answers for it
  std::int64_t next_id = 0;                      // ids from here on were never given; 0 = none was made
};

[[nodiscard]] ReviewRecord read_review(const std::filesystem::path& path);
void write_review(const std::filesystem::path& path, const ReviewRecord& record);

}  // namespace cairn::pipeline
