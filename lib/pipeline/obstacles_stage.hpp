// Stage `obstacles`: targets, poses and terrain -> obstacles of a ground vehicle.
#pragma once

#include <filesystem>
#include <memory>

#include "base/run_context.hpp"
#include "ground/obstacles.hpp"
#include "pipeline/outcome.hpp"
#include "pipeline/stage.hpp"

namespace cairn::pipeline {

struct ObstaclesInputs {
  std::filesystem::path survey;   // survey folder
  std::filesystem::path targets;  // targets.json
  std::filesystem::path terrain;  // surface.tif; "" = the foot is taken from the object's own height
};

// Writes obstacles.json into `out`. Throws crs_mismatch where the targets are in another frame than the survey.
Outcome obstacles_stage(const ObstaclesInputs& in, const std::filesystem::path& out,
                        const ground::ObstacleOptions& options, base::RunContext& ctx);

// The recipe's stage `obstacles`.
[[nodiscard]] std::unique_ptr<Stage> make_obstacles_stage();

}  // namespace cairn::pipeline
