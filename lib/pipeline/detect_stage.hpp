// Stage `detect`: images of a survey and a detector -> detections.
#pragma once

#include <filesystem>

#include "base/run_context.hpp"
#include "detection/options.hpp"
#include "pipeline/outcome.hpp"

namespace cairn::pipeline {

struct DetectInputs {
  std::filesystem::path survey;  // survey folder whose frames name images
  std::filesystem::path model;   // ONNX
  std::filesystem::path names;   // class names, one a line; "" = the model's
};

// Writes `out`, a detections.csv: ids 1, 2, 3 by frame, then falling score; pixels of the raw images, corner
// convention. Rejects: no_image (the frame names none), unreadable_image. Throws where the model cannot be used, or
// where no image could be read.
Outcome detect_stage(const DetectInputs& in, const std::filesystem::path& out, const detection::DetectOptions& options,
                     base::RunContext& ctx);

}  // namespace cairn::pipeline
