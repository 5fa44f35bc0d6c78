// The re-flight that closes the gaps of a coverage audit.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "base/reject.hpp"
#include "base/run_context.hpp"
#include "io/json.hpp"
#include "pipeline/plan_stage.hpp"
#include "survey/mission.hpp"

namespace cairn::pipeline {

struct GapPlan {
  survey::Mission mission;
  std::vector<std::size_t> view_waypoint;
  planning::SurfaceHeights surface{0.0};
  std::vector<std::pair<std::string, io::Json>> figures;  // for the summary
  io::Json coverage;                                      // coverage.json
  std::vector<base::Reject> rejects;                      // gaps and targets that no permitted view can close
};

// Reads the audit's surface, views, gates and targets as its run.json names them (in.terrain, in.survey and in.targets
// go before), makes candidate views about what fails, keeps those that are clear of the surface, chooses by
// planning::select_views, orders them into a short tour, drops the last chosen until the time fits the budget, and
// repeats the audit with recorded and planned views together.
[[nodiscard]] GapPlan plan_gaps(const PlanInputs& in, const PlanStageOptions& options, base::RunContext& ctx);

void write_gap_coverage(const GapPlan& plan, const std::filesystem::path& out);

}  // namespace cairn::pipeline
