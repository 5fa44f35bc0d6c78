// What a reviewer's decisions make of a result's rocks, before anything is computed again.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "geometry/vec.hpp"
#include "pipeline/review_record.hpp"
#include "survey/edit.hpp"
#include "survey/rock.hpp"

namespace cairn::pipeline {

// The points of a rock change owner. Changes are carried out in the order they were decided.
struct PointChange {
  std::uint64_t line = 0;  // of edits.csv
  std::int64_t rock = 0;
  std::int64_t merged = -1;           // its points go to `rock`; -1 = a split
  std::vector<geometry::Vec3> seeds;  // split: one a part, local ENU, m; each point goes to the nearest
  bool seeds_have_height = false;     // false: nearest in plan
  std::vector<std::int64_t> parts;    // split: id of each part; the first is `rock`
};

struct ReviewPlan {
  std::vector<survey::Rock> rocks;  // ascending id; those without new points are final but for a new density
  ReviewRecord record;              // to be written with the result
  std::vector<PointChange> changes;
  std::set<std::int64_t> reshaped;              // rocks whose surface and tipping are computed again
  std::map<std::int64_t, double> densities;     // rocks whose tipping is computed again, kg/m3
  std::set<std::int64_t> gone;                  // merged ids: no record and no files any more
  std::map<std::int64_t, std::int64_t> born;    // id of a split part -> the rock it was part of
  std::map<std::string, std::int64_t> applied;  // decisions by action, new ones only
};

struct ReviewContext {
  std::filesystem::path edits_file;  // for messages
  std::string slug;                  // of the survey: first part of inventory ids
  bool has_points = false;           // whether the result holds labelled points
  bool has_meshes = false;           // whether it holds the rocks' meshes
};

// Throws invalid_input with the line of edits.csv: an unknown id (or one of another survey), a merge or split of a
// rejected rock, of a rock with itself or with one merged already, seeds that cannot be read, a field that is not known
// or a value that does not fit it; failed_precondition where the result holds no labelled points or meshes to change.
// `before`: of a result that was reviewed already; `edits` must begin with its decisions.
[[nodiscard]] ReviewPlan plan_review(std::vector<survey::Rock> rocks, const ReviewRecord& before,
                                     const std::vector<survey::Edit>& edits, const ReviewContext& context);

}  // namespace cairn::pipeline
