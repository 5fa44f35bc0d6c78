// Stage `simulate`: a scene -> a recorded survey with truth.
#pragma once

#include <filesystem>

#include "base/run_context.hpp"
#include "pipeline/outcome.hpp"
#include "simulation/scene.hpp"

namespace cairn::pipeline {

// Writes into `out` a survey folder (docs/formats/survey_folder.md):
//   survey.json, frames.csv, detections.csv     what the flight recorded, with ctx.seed's errors
//   truth.json, truth/                          what was true; truth/terrain.ply and truth/meshes/<id>.ply
//   images/, depth/, masks/                     where the scene asks for them, one file a frame
//   cloud.las                                   where the scene asks for it
// Pictures are rendered and written one frame at a time: memory does not grow with their number.
// Throws as simulation::simulate.
Outcome simulate_stage(const simulation::Scene& scene, const std::filesystem::path& out, base::RunContext& ctx);

// Counts of what simulate_stage would write, without errors drawn and without pictures.
[[nodiscard]] io::Json simulate_plan(const simulation::Scene& scene, base::RunContext& ctx);

}  // namespace cairn::pipeline
