// Is what the tables say possible? Times, doubles, boxes, images, heights.
#pragma once

#include <filesystem>
#include <map>
#include <optional>

#include "io/json.hpp"
#include "pipeline/check_findings.hpp"
#include "pipeline/check_options.hpp"
#include "pipeline/check_tables.hpp"

namespace cairn::pipeline {

// Codes: no_frames, no_cameras, convention_assumed, camera_implausible, duplicate_image, duplicate_pose,
// time_not_ascending, duplicate_time, duplicate_detection, box_outside_image, box_empty, no_tie_points,
// survey_empty_tie. Adds counts to `evidence`.
void check_records(const CheckedSurvey& checked, const std::filesystem::path& folder, const CheckOptions& options,
                   Findings& findings, io::Json& evidence);

// Files of the frames that can be decoded, by frame. Codes: image_missing, image_unreadable,
// image_size_mismatch, no_image. Headers only. Cost: a few kilobytes an image.
[[nodiscard]] std::map<survey::FrameId, std::filesystem::path> check_images(const CheckedSurvey& checked,
                                                                            const std::filesystem::path& folder,
                                                                            Findings& findings, io::Json& evidence);

// Heights of the cameras above the ground [m, local up of the ground per frame], and whether their axes
// meet it. `ground` holds the frames whose ground is known. Codes: height_above_ground,
// axis_misses_ground.
void check_heights(const CheckedSurvey& checked, const std::filesystem::path& folder,
                   const std::map<survey::FrameId, double>& ground, const std::string& ground_by,
                   const CheckOptions& options, Findings& findings, io::Json& evidence);

}  // namespace cairn::pipeline
