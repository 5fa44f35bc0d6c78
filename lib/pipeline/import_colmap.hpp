// COLMAP model + images -> survey.
#pragma once

#include <filesystem>
#include <optional>

#include "pipeline/import_survey.hpp"

namespace cairn::pipeline {

struct ImportColmapInputs {
  ImportInputs common;  // origin and height_type are required
  std::filesystem::path model;
  std::filesystem::path images;
  // Image file pixels / model pixels; empty = taken from the sizes of the image files.
  std::optional<double> scale_images;
};

// The model must be in metres, in the east-north-up frame about the origin (model_aligner's ENU).
// The survey's pixels are those of the image files: intrinsics, tie observations, and boxes unless
// detections_scale says otherwise, are multiplied by the scale.
// Throws not_found naming the images that are missing, invalid_input where an image cannot be read or
// has another size than camera * scale, invalid_argument without origin or height type.
[[nodiscard]] Outcome import_colmap(const ImportColmapInputs& in, const std::filesystem::path& out,
                                    base::RunContext& ctx);

}  // namespace cairn::pipeline
