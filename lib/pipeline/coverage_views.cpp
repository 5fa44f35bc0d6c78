#include "pipeline/coverage_views.hpp"

#include <algorithm>
#include <utility>

#include "io/camera_table.hpp"
#include "io/mission_json.hpp"
#include "io/survey_folder.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;

namespace {

CoverageViews views_of_mission(const fs::path& path) {
  const survey::Mission mission = io::read_mission(path);
  CoverageViews views;
  views.origin = mission.origin;
  views.set.cameras = {mission.camera};
  for (const survey::Frame& view : mission.views) views.set.views.push_back({view.id, 0, view.T_world_camera});
  return views;
}

}  // namespace

CoverageViews read_coverage_views(const fs::path& path, const std::string& format) {
  // A planned mission, or the folder that `cairn plan` wrote.
  const fs::path in_folder = path / "mission.json";
  if (format == "mission" || (format == "auto" && fs::is_directory(path) && fs::exists(in_folder)))
    return views_of_mission(fs::is_directory(path) ? in_folder : path);
  if (format == "auto" && fs::is_regular_file(path) && io::is_mission_file(path)) return views_of_mission(path);
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
