#include "pipeline/coverage_views.hpp"

#include <algorithm>
#include <utility>

#include "io/camera_table.hpp"
#include "io/survey_folder.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;

CoverageViews read_coverage_views(const fs::path& path, const std::string& format) {
  CoverageViews views;
  if (format == "pinhole-table" || (format == "auto" && !fs::is_directory(path))) {
    for (const io::TableView& row : io::read_camera_table(path)) {
      if (views.set.cameras.empty() || !(views.set.cameras.back() == row.camera))
        views.set.cameras.push_back(row.camera);
      views.set.views.push_back({survey::FrameId(static_cast<std::int64_t>(views.set.views.size())),
                                 views.set.cameras.size() - 1, row.T_world_camera});
    }
    return views;
  }
  survey::Survey survey = io::read_survey(path);
  views.origin = survey.manifest.origin;
  views.set.cameras = survey.manifest.cameras;
  std::vector<survey::Frame> kept;
  for (survey::Frame& frame : survey.frames) {
    const auto camera = std::find_if(views.set.cameras.begin(), views.set.cameras.end(),
                                     [&](const survey::Camera& c) { return c.id == frame.camera; });
    if (camera == views.set.cameras.end()) {
      views.rejects.push_back({"frame " + std::to_string(frame.id.value), "camera_missing",
                               "the survey has no camera " + std::to_string(frame.camera.value)});
      continue;
    }
    views.set.views.push_back({frame.id, static_cast<std::size_t>(camera - views.set.cameras.begin()),
                               frame.T_world_camera, frame.sigma_xy_m, frame.sigma_z_m, frame.sigma_rot_deg});
    kept.push_back(std::move(frame));
  }
  survey.frames = std::move(kept);
  views.survey = std::move(survey);
  return views;
}

}  // namespace cairn::pipeline
