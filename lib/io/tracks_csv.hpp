// tracks.csv: boxes with the identities of an image tracker.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "survey/survey.hpp"
#include "survey/tracklet.hpp"

namespace cairn::io {

// Columns detection_id,frame_id,class,score,xmin_px,ymin_px,xmax_px,ymax_px,track_id,state, in any order, others
// ignored. detection_id is empty where the box was coasted. Rows come back by frame, then track id.
// Throws invalid_input with line and column: a frame the survey does not have, a detected row without a detection id,
// an unknown state, a box that ends before it begins, a score that is not finite, a track twice in one frame.
// Where the survey has detections, the detection ids of the rows must be among them.
[[nodiscard]] std::vector<survey::TrackedBox> read_tracks(const std::filesystem::path& path,
                                                          const survey::Survey& survey);

// In the order given. Throws invalid_input where a value is not finite, resource_exhausted where a write fails.
void write_tracks(const std::filesystem::path& path, std::span<const survey::TrackedBox> tracks);

}  // namespace cairn::io
