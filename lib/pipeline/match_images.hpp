// The images of a survey folder -> tie points, with turned frames put right.
#pragma once

#include <filesystem>
#include <vector>

#include "adjustment/tie_matches.hpp"
#include "base/reject.hpp"
#include "base/run_context.hpp"
#include "io/json.hpp"
#include "survey/survey.hpp"

namespace cairn::pipeline {

struct MatchedSurvey {
  survey::Survey survey;             // ties replaced; poses and cameras of turned frames put right, with a note
  adjustment::MatchedTies matching;  // its `ties` were moved into the survey
  bool one_height = false;           // all views look down from about one height: no evidence on the focal length
  io::Json summary;                  // counts, turned frames with their evidence, pairs, rejects
};

// References of images are resolved against `folder`. Turned frames are named in the manifest and as a warning; a
// turned camera with an eccentric principal point or tangential terms gets a mirrored twin. Throws failed_precondition
// where no two images share enough points, or no frame names an image. Memory and cost: adjustment::match_ties.
[[nodiscard]] MatchedSurvey match_images(survey::Survey survey, const std::filesystem::path& folder,
                                         const adjustment::TieMatchOptions& options, base::RunContext& ctx);

}  // namespace cairn::pipeline
