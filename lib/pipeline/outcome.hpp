// What a stage gives back beside the files it wrote.
#pragma once

#include <vector>

#include "base/reject.hpp"
#include "io/json.hpp"

namespace cairn::pipeline {

struct Outcome {
  io::Json summary;                   // counts and figures, units in the names; the same on every run
  std::vector<base::Reject> rejects;  // records left out, each with a reason code
};

// Counts by reason code, ascending by code: {"at_image_edge": 3, ...}.
[[nodiscard]] io::Json count_by_reason(const std::vector<base::Reject>& rejects);
// The rejects as a list of {record, reason, message}.
[[nodiscard]] io::Json to_json(const std::vector<base::Reject>& rejects);

}  // namespace cairn::pipeline
