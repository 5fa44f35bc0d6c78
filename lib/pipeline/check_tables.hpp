// Reads a survey folder as far as it can be read, and says of every record why it cannot.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "pipeline/check_findings.hpp"
#include "survey/survey.hpp"

namespace cairn::pipeline {

struct CheckedSurvey {
  survey::Survey survey;    // the records that can be used, ascending id
  bool has_origin = false;  // the origin in survey.json is a place on Earth
  std::size_t frame_rows = 0, detection_rows = 0, tie_rows = 0, observation_rows = 0;  // as in the tables
  std::map<survey::FrameId, std::string> frame_records;          // "line 7 (frame 12, DJI_0012.JPG)"
  std::map<survey::DetectionId, std::string> detection_records;  // "line 9 (detection 4)"
};

// What the strict reader (io::read_survey) refuses at the first fault is refused here record by record:
// codes survey_json, origin_out_of_range, camera_invalid, source_invalid, table_missing, table_malformed,
// cell_invalid, duplicate_id, frame_without_pose, pose_not_finite, quaternion_not_unit, unknown_camera,
// unknown_frame, unknown_tie, box_inverted, score_out_of_range. A record with a fault is left out.
// Cost linear in bytes.
[[nodiscard]] CheckedSurvey read_for_check(const std::filesystem::path& folder, Findings& findings);

}  // namespace cairn::pipeline
