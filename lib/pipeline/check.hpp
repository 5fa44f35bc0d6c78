// Proves a survey sound, with evidence.
#pragma once

#include <filesystem>

#include "base/run_context.hpp"
#include "io/json.hpp"
#include "pipeline/check_findings.hpp"
#include "pipeline/check_options.hpp"

namespace cairn::pipeline {

struct CheckResult {
  bool ok = true;  // no finding of severity error
  std::vector<Finding> findings;
  io::Json evidence;  // figures with units in their names; the members stand in docs/commands/check.md

  [[nodiscard]] io::Json to_json() const;  // {"ok", "findings", "evidence"}
};

// Reads the survey as far as it can be read and lists every fault, not only the first. Throws not_found
// only where the folder does not exist; everything else becomes a finding. Nothing is written.
// Cost on 18 images of 1600 x 900 and 234,000 points: about 3 s with tie points, 9 s without, one core.
[[nodiscard]] CheckResult check_survey(const std::filesystem::path& folder, const CheckOptions& options,
                                       base::RunContext& ctx);

}  // namespace cairn::pipeline
