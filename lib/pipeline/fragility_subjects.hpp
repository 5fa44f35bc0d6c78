// What `cairn fragility` reads: meshes, records of `cairn surface`, digitised contacts, coverage audits.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/reject.hpp"
#include "fragility/assessment.hpp"
#include "geometry/triangle_mesh.hpp"
#include "io/contact_csv.hpp"
#include "survey/coverage_gap.hpp"
#include "survey/rock.hpp"

namespace cairn::pipeline {

// One rock before its assessment.
struct FragilitySubject {
  std::string stem;  // of its files
  survey::Rock rock;
  std::optional<geometry::TriangleMesh> mesh;  // empty where the rock was rejected before
  survey::Contact contact;                     // sorted
  fragility::Evidence evidence;
  std::string north = "mesh +y";  // what azimuths are counted from: "true north" in a local ENU frame
  std::string refusal = "the rock has no closed surface";

  [[nodiscard]] fragility::Subject for_assessment() const;
};

// A closed mesh in metres; its base is assumed: the outline of its band of lowest points.
[[nodiscard]] FragilitySubject subject_of_mesh(const std::filesystem::path& path,
                                               const fragility::FragilityOptions& options);

// <id>.json and <id>.ply of `cairn surface`. Throws invalid_input for a record that is not whole, failed_precondition
// where the mesh is not the one the record describes.
[[nodiscard]] FragilitySubject subject_of_record(const std::filesystem::path& record);

// Records of a surface folder in order of id.
[[nodiscard]] std::vector<FragilitySubject> subjects_of_folder(const std::filesystem::path& folder);

// Takes the digitised contact in place of the one at hand, where the file has one for the rock (single: any); the
// reject `contact_outside_rock` where it lies elsewhere.
[[nodiscard]] std::optional<base::Reject> take_contact(FragilitySubject& subject, const io::ContactFile& file,
                                                       bool single);

// Puts the share of the contact's perimeter that lies outside all gaps (in plan) into the evidence. Same local frame.
void take_coverage(FragilitySubject& subject, const std::vector<survey::CoverageGap>& gaps);

// Gaps of a coverage folder or of its gaps.json. Throws not_found.
[[nodiscard]] std::vector<survey::CoverageGap> read_coverage_gaps(const std::filesystem::path& path);

}  // namespace cairn::pipeline
