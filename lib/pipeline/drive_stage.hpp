// Stage `simulate --drive`: a scene with a ground vehicle -> the survey folder of one closed loop.
#pragma once

#include <filesystem>

#include "base/run_context.hpp"
#include "pipeline/ground_run.hpp"
#include "pipeline/outcome.hpp"

namespace cairn::pipeline {

// Writes into `out` a survey folder (docs/formats/survey_folder.md):
//   survey.json, frames.csv, detections.csv   what the aircraft recorded until the vehicle arrived
//   vehicle.csv, lidar.csv, packets.bin       the vehicle's inertial log and scans, the packets it received
//   prior/map.{pgm,yaml,georeference.json}    the map it had before
//   truth.json, truth/                        what was true; truth/vehicle.csv, 50 Hz
//   drive/drive.json                          how it went: arrival, way, contacts, plans, update periods, pose errors
//   drive/vehicle.csv, drive/plans.csv        filtered track; every global path that was followed
//   drive/paths.svg, drive/costmap_*.svg, drive/update_periods.svg
// Throws as DriveRehearsal and run_ground.
Outcome drive_stage(const simulation::Scene& scene, const std::filesystem::path& out, const GroundRunOptions& options,
                    base::RunContext& ctx);

// drive.json without the names of the scene and the seed.
[[nodiscard]] io::Json drive_json(const GroundRecord& record);

}  // namespace cairn::pipeline
