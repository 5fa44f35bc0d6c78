// Stage `review`: a result and the reviewer's decisions -> the result with the decisions applied.
#pragma once

#include <filesystem>

#include "base/run_context.hpp"
#include "io/json.hpp"
#include "pipeline/outcome.hpp"

namespace cairn::pipeline {

struct ReviewFiles {
  std::filesystem::path result;  // folder of cairn run, review or fragility
  std::filesystem::path edits;   // edits.csv
  std::filesystem::path survey;  // survey folder; "" = not known: layers, inventory and report are not made again
};

// Writes the whole result into `out` as a new folder; `files.result` is left as it is. Copied byte for byte: all that
// no decision touches. Computed again: surface and tipping of merged and split rocks, tipping of rocks with another
// density, by the stages and options that made the result; then layers, inventory and report where the result had them.
// Also written: review.json, edits.csv. Rocks keep their ids; a merged one answers as an alias; parts of a split beyond
// the first get ids that were never used.
// Rejects: rocks that could not be computed again. Throws as plan_review and change_points.
[[nodiscard]] Outcome review_files(const ReviewFiles& files, const std::filesystem::path& out, base::RunContext& ctx);

// What run.json of the reviewed result carries on from the result: its stages with their options.
[[nodiscard]] io::Json carried_record(const std::filesystem::path& result);
// Seed of the result; 0 where it is not known.
[[nodiscard]] std::uint64_t seed_of_result(const std::filesystem::path& result);

}  // namespace cairn::pipeline
