// What a coverage audit was made of, read from its folder.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/reject.hpp"
#include "coverage/audit.hpp"
#include "coverage/coverage.hpp"
#include "coverage/gaps.hpp"
#include "coverage/target_audit.hpp"
#include "pipeline/plan_stage.hpp"

namespace cairn::pipeline {

// Files, and options as its run.json has them.
struct Audited {
  std::filesystem::path surface, views, targets, contacts;
  std::string format = "auto";
  coverage::CoverageOptions visibility;
  coverage::GateOptions gates;
  coverage::GapOptions gaps;
  coverage::TargetOptions target_options;
};

// From the run.json of `cairn coverage`, or of a recipe (then surface.tif, targets.json and the survey it was run on,
// with default options); in.terrain, in.survey and in.targets go before. Throws not_found where there is no run.json,
// or a file that is named is not there.
[[nodiscard]] Audited read_audited(const PlanInputs& in);

// Leaves out targets, and rejects of targets, whose class is not one of `classes` (separated by commas; "" keeps all).
void keep_classes(std::vector<coverage::TargetBody>& bodies, std::vector<base::Reject>& rejects,
                  const std::filesystem::path& targets, const std::string& classes);

}  // namespace cairn::pipeline
