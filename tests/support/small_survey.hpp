// A small survey over gently sloping ground, seen by nadir frames.
#pragma once

#include <cmath>
#include <filesystem>

#include "io/survey_folder.hpp"
#include "support/views.hpp"
#include "survey/survey.hpp"

namespace cairn::testing {

inline const geometry::Geodetic kSmallSurveyOrigin{46.8426, -91.994, 158.0};

inline double small_survey_up(double east, double north) {
  return 1.0 + 0.05 * east - 0.02 * north;
}

// `frames` frames in a row from (0, 10) to (20, 10), 20 m up, 24 x 18 m on the ground each. The cloud, if named, is in
// the local frame.
inline survey::Survey small_survey(int frames, const std::string& cloud = "") {
  survey::Survey survey;
  survey.manifest.name = "small";
  survey.manifest.origin = {kSmallSurveyOrigin, survey::HeightType::ellipsoidal, ""};
  survey.manifest.cameras.push_back(pinhole_camera(1000, 1200, 900));
  if (!cloud.empty()) {
    survey::Source source;
    source.kind = "cloud";
    source.path = cloud;
    source.crs = "local";
    source.height_type = survey::HeightType::ellipsoidal;
    survey.manifest.sources.push_back(source);
  }
  for (int i = 0; i < frames; ++i) {
    survey::Frame frame;
    frame.id = survey::FrameId(i);
    frame.camera = survey::CameraId(0);
    const double east = frames > 1 ? 20.0 * i / (frames - 1) : 10.0;
    frame.T_world_camera = io::exact_pose(looking_at(geometry::Vec3(east, 10, 20), geometry::Vec3(east, 10, 0)));
    survey.frames.push_back(frame);
  }
  return survey;
}

inline void write_small_survey(const std::filesystem::path& folder, int frames, const std::string& cloud = "") {
  std::filesystem::create_directories(folder);
  io::write_survey(small_survey(frames, cloud), folder);
}

}  // namespace cairn::testing
