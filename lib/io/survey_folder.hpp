// A survey on disk: survey.json and its tables (docs/formats/survey_folder.md is the contract of every field).
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "survey/survey.hpp"

namespace cairn::io {

// Reads survey.json, frames.csv and, where they exist, detections.csv, tie_points.csv and
// tie_observations.csv. Records come back in ascending id.
//
// Structural faults throw invalid_input (exit 4) with file, line, value: an unknown schema version, a
// duplicate id, an unknown frame, camera or tie, a pose that is not finite, a quaternion whose norm is
// not 1 within 1e-3, a box with max < min, a score outside 0..1. A latitude or longitude out of range
// throws crs_mismatch (exit 6). What is merely suspicious (a box outside its image, an image that does
// not exist, times out of order) is read, and found by `check`.
// Cost linear in bytes, n log n in records.
[[nodiscard]] survey::Survey read_survey(const std::filesystem::path& folder);

// Writes the files into an existing folder (a staged one). Tables without rows are left out, frames.csv
// apart. Numbers are in shortest round-trip form. A survey that was read, or whose poses went through
// `exact_pose`, reads back bit for bit; the rotation of any other to within 1e-15.
// Throws invalid_input where a value is not finite, resource_exhausted where a write fails.
void write_survey(const survey::Survey& survey, const std::filesystem::path& folder);

// A table of detections alone, in the order given. Throws as write_survey.
void write_detections(const std::filesystem::path& path, std::span<const survey::Detection> detections);

// A table of frames by itself, such as truth/frames.csv: the same columns and checks; any camera id is taken.
[[nodiscard]] std::vector<survey::Frame> read_frames(const std::filesystem::path& path);
void write_frames(const std::filesystem::path& path, const std::vector<survey::Frame>& frames);

// The pose with its rotation replaced by the nearest one (1e-15 rad) that its text gives back exactly.
// Importers apply it, so that a survey in memory equals the same survey read from disk.
[[nodiscard]] geometry::RigidTransform exact_pose(const geometry::RigidTransform& pose);

// How a survey in `survey_folder` (its final name; need not exist yet) names a file: relative where the
// file lies inside the survey folder or inside the folder that holds it ("../images/a.jpg"), else
// absolute. Nothing is copied.
[[nodiscard]] std::string file_reference(const std::filesystem::path& file, const std::filesystem::path& survey_folder);

// The file a reference names; empty for an empty reference.
[[nodiscard]] std::filesystem::path resolve_reference(const std::string& reference,
                                                      const std::filesystem::path& survey_folder);

}  // namespace cairn::io
