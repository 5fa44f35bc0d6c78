// Runs the evidence of module `adjustment` on a checked survey and turns it into findings.
#pragma once

#include <filesystem>
#include <map>
#include <optional>

#include "base/run_context.hpp"
#include "io/json.hpp"
#include "pipeline/check_cloud.hpp"
#include "pipeline/check_findings.hpp"
#include "pipeline/check_options.hpp"
#include "pipeline/check_tables.hpp"

namespace cairn::pipeline {

// Tie points. Codes: those of adjustment::PoseHypothesis, image_scale, half_pixel_shift,
// reprojection_error (bad, and nothing explains it), no_tie_points (info). Returns whether the tie
// points prove the poses of at least nine frames in ten.
bool check_ties(const CheckedSurvey& checked, const std::filesystem::path& folder, const CheckOptions& options,
                Findings& findings, io::Json& evidence);

// Matches between images; `ground` gets the plane below each frame. Codes: those of
// adjustment::PoseHypothesis, pairs_disagree, pairs_unmatched (info).
void check_pairs(const CheckedSurvey& checked, const std::filesystem::path& folder,
                 const std::map<survey::FrameId, std::filesystem::path>& images, const CheckOptions& options,
                 base::RunContext& ctx, Findings& findings, io::Json& evidence,
                 std::map<survey::FrameId, double>& ground);

// Cloud against images and tie points. Codes: cloud_offset.
void check_cloud_evidence(const CheckedSurvey& checked, const CheckedCloud& cloud,
                          const std::map<survey::FrameId, std::filesystem::path>& images, const CheckOptions& options,
                          base::RunContext& ctx, Findings& findings, io::Json& evidence);

// "DJI_0024-DJI_0029,DJI_0031": names of the frames' images without extension, runs joined.
[[nodiscard]] std::string frame_ranges(const survey::Survey& survey, const std::vector<survey::FrameId>& frames);

}  // namespace cairn::pipeline
