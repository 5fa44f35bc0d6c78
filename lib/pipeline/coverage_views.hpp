// The views of a coverage audit: the frames of a survey, the images of a planned mission, or a table of cameras.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/reject.hpp"
#include "coverage/view.hpp"
#include "survey/survey.hpp"

namespace cairn::pipeline {

struct CoverageViews {
  coverage::ViewSet set;
  std::optional<survey::Origin> origin;  // of the frame the poses are in; empty for a camera table
  std::vector<base::Reject> rejects;     // frames without their camera
  std::optional<survey::Survey> survey;  // where the views are its frames, in their order without those rejected
};

// format: "auto" (a folder with mission.json and such a file are a mission, another folder is a survey, another file a
// camera table), "survey", "mission", "pinhole-table". Throws as the readers do.
[[nodiscard]] CoverageViews read_coverage_views(const std::filesystem::path& path, const std::string& format);

}  // namespace cairn::pipeline
