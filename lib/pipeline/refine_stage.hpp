// Stage `refine`: poses, tie points and control points -> a survey with refined poses.
#pragma once

#include <filesystem>
#include <string>

#include "adjustment/bundle_options.hpp"
#include "adjustment/tie_matches.hpp"
#include "base/run_context.hpp"
#include "pipeline/outcome.hpp"

namespace cairn::pipeline {

struct RefineInputs {
  std::filesystem::path survey;        // survey folder; it is not changed
  std::filesystem::path control;       // ground control points (io/control_points.hpp); "" = none
  std::filesystem::path final_folder;  // where the result will stand: its references are relative to it
};

struct RefineStageOptions {
  bool match = false;  // tie points from the images, in place of the survey's
  adjustment::TieMatchOptions matching;
  adjustment::BundleOptions bundle;
  std::string control_crs;           // over what the file declares
  double control_image_scale = 1.0;  // pixels of the file times this = pixels of the survey's images

  void visit(base::OptionVisitor& visitor) {
    visitor.flag("match", match, "find tie points in the images, in place of the survey's");
    matching.visit(visitor);
    bundle.visit(visitor);
    visitor.text("control-crs", control_crs, "CRS of the control points, over what their file declares");
    visitor.real("control-image-scale", control_image_scale, 1e-3, 1e3,
                 "pixels of the control points' file times this = pixels of the survey's images");
  }
};

// Writes into `out` a complete survey folder (poses and their sigmas, intrinsics where asked for, detections, the tie
// points used at their adjusted places, sources) and refine_frames.csv, one row a frame.
// Throws failed_precondition where the survey has no tie points.
Outcome refine_stage(const RefineInputs& in, const std::filesystem::path& out, const RefineStageOptions& options,
                     base::RunContext& ctx);

}  // namespace cairn::pipeline
