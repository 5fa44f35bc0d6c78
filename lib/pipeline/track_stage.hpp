// Stage `track`: boxes of successive images to tracks.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/run_context.hpp"
#include "io/detections.hpp"
#include "pipeline/outcome.hpp"
#include "tracking/frame_order.hpp"
#include "tracking/options.hpp"

namespace cairn::pipeline {

struct TrackStageOptions {
  tracking::SortOptions sort;
  tracking::FrameOrderOptions order;  // surveys only: files have no time stamps
  std::string boxes = "auto";  // filtered: the filter's estimate; detected: the detector's own box where there is
                               // one; auto: detected in surveys, filtered in files
  bool scores = true;          // write the score of the box matched last; false: 1, as the reference does

  void visit(base::OptionVisitor& visitor);
};

// A survey folder with detections -> `out`, tracks.csv. Frames of each camera are a sequence of their own.
// Throws failed_precondition where the survey has no detections.
Outcome track_survey(const std::filesystem::path& survey, const std::filesystem::path& out,
                     const TrackStageOptions& options, base::RunContext& ctx);

struct TrackFile {
  std::filesystem::path in, out;
};
struct TrackFileInputs {
  std::string format = "auto";  // of all files; auto = recognised from each
  io::ReadBoxesOptions reading;
};

// Each file of boxes is a sequence of its own -> a MOTChallenge result. MOT pixels stay as they are; of other formats
// frames are numbered 1, 2, 3 in the order of their images, and pixels are in the corner convention.
// Frames without boxes are stepped too, from 1 (or from the first frame where a file counts from 0) to the last.
Outcome track_files(const std::vector<TrackFile>& files, const TrackFileInputs& in, const TrackStageOptions& options,
                    base::RunContext& ctx);

// Names of the results in a folder: the file's stem, or the folder above where files are named det (MOTChallenge's
// SEQUENCE/det/det.txt). Throws invalid_argument where two files would have one name.
[[nodiscard]] std::vector<TrackFile> results_in_folder(const std::vector<std::filesystem::path>& inputs,
                                                       const std::filesystem::path& folder);

}  // namespace cairn::pipeline
