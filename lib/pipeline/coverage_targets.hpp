// The targets of a coverage audit: from targets.json, with their contacts; and what was found, as rows.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "base/reject.hpp"
#include "coverage/target_audit.hpp"
#include "geodesy/local_frame.hpp"
#include "io/json.hpp"
#include "survey/manifest.hpp"

namespace cairn::pipeline {

struct CoverageTargets {
  std::vector<coverage::TargetBody> bodies;
  std::vector<base::Reject> rejects;  // no_cylinder: nothing says how large the target is
};

// targets: targets.json; those given up are left out silently, the others stand with the cylinder of their fitted body,
// else of their points. contacts: contact.csv, or ""; rows are joined by rock_id = target id and are in the local frame
// unless the file declares a CRS.
// Throws crs_mismatch where the targets are in another frame than the views, or contacts need a frame and there is
// none.
[[nodiscard]] CoverageTargets read_coverage_targets(const std::filesystem::path& targets,
                                                    const std::filesystem::path& contacts,
                                                    const std::optional<survey::Origin>& origin);

// One object a target, as in targets_coverage.json.
[[nodiscard]] io::Json to_json(const coverage::TargetAudit& target);

// targets_coverage.csv: a row a target.
void write_target_rows(const std::filesystem::path& path, const std::vector<coverage::TargetAudit>& targets);

}  // namespace cairn::pipeline
