// Stage `fragility`: closed meshes + contact -> tipping with its grade.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "fragility/assessment.hpp"
#include "pipeline/outcome.hpp"
#include "pipeline/stage.hpp"

namespace cairn::pipeline {

struct FragilityFiles {
  std::filesystem::path input;    // a mesh, or a folder that `surface` wrote
  std::filesystem::path contact;  // contact.csv; "" = the base is assumed
  // A folder of `coverage`, or its gaps.json, in the meshes' frame; "" = none.
  std::filesystem::path coverage;
};

// Writes rocks.json, and for each rock that can be measured <id>_tipping.json (every edge, the tables by azimuth),
// <id>_tipping.svg and, with draws, <id>_draws.csv. A rock of grade not_measurable appears in rocks.json with its
// reasons and without any angle. Summary "rocks": the rows of rock_summary() (fragility_products.hpp). A mesh that is
// not closed, or a contact that does not lie at the rock, is a reject.
[[nodiscard]] Outcome fragility_files(const FragilityFiles& in, const std::filesystem::path& out, bool density_assumed,
                                      const fragility::FragilityOptions& options, base::RunContext& ctx);

// The recipe's stage: rocks/<id>.{ply,json}, segments.json -> rocks.json, rocks/<id>_tipping.{json,svg},
// rocks/<id>_draws.csv.
// rocks.json also holds the targets that were not cut, with `rejected` and their reasons.
[[nodiscard]] std::unique_ptr<Stage> make_fragility_stage();

}  // namespace cairn::pipeline
