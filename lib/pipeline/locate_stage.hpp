// Stage `locate`: detections and poses -> targets.
#pragma once

#include <filesystem>
#include <memory>

#include "base/run_context.hpp"
#include "localisation/body_fit.hpp"
#include "localisation/locate.hpp"
#include "pipeline/outcome.hpp"
#include "pipeline/stage.hpp"

namespace cairn::pipeline {

struct LocateInputs {
  std::filesystem::path survey;   // survey folder with detections
  std::filesystem::path terrain;  // surface.tif of stage `terrain`; "" = depth from the tie points
  std::filesystem::path tracks;   // tracks.csv of `cairn track`; "" = all detections
};

struct LocateStageOptions {
  localisation::LocateOptions locate;
  bool points = true;         // write the filter's points of each target that was not given up
  bool plots = true;          // draw how they gathered
  bool refine_bodies = true;  // fit one body to all boxes of each converged target
  localisation::BodyFitOptions body;

  void visit(base::OptionVisitor& visitor) {
    locate.visit(visitor);
    visitor.flag("points", points, "write the points of each target to points/<id>.ply");
    visitor.flag("plots", plots, "draw each target's entropy and divergence to plots/<id>.svg");
    visitor.flag("refine-bodies", refine_bodies, "fit one body to all boxes of each converged target");
    body.visit(visitor);
  }
};

// Writes into `out`:
//   targets.json          the targets, deregistered ones too
//   target_evidence.csv   one row a target: what its state rests on, and the filter's own centre beside the final one
//   points/<id>.ply       the filter's points of each target that was not given up
//   plots/<id>.svg        their entropy and divergence over the keyframes
//   drift.csv             where a drift of the positions was found: what was taken off each frame's
// Throws failed_precondition where the survey has no detections.
Outcome locate_stage(const LocateInputs& in, const std::filesystem::path& out, const LocateStageOptions& options,
                     base::RunContext& ctx);

// The recipe's stage `locate`.
[[nodiscard]] std::unique_ptr<Stage> make_locate_stage();

}  // namespace cairn::pipeline
