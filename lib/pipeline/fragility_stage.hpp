// Stage `fragility`: closed meshes + contact -> tipping with its grade.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "fragility/assessment.hpp"
#include "pipeline/outcome.hpp"
#include "pipeline/stage.hpp"

namespace cairn::pipeline {

struct FragilityFiles {
  std::filesystem::path input;    // a mesh, or a folder that `surface` wrote
  std::filesystem::path contact;  // contact.csv; "" = the base is assumed
};

// Writes rocks.json, and for each rock that can be measured <id>_tipping.json (every edge, the polar table) and
// <id>_tipping.svg. A rock of grade not_measurable appears in rocks.json with its reasons and without any angle.
// Summary "rocks": per rock volume_m3, mass_kg, com_m, inertia_kg_m2, contact, grade, reasons, and where measurable
// alpha_min_deg, azimuth_deg (the same as topple_toward_deg, the name files use), r_m, p_rad_s, a_qs_g,
// a_qs_g_by_azimuth, v_min_m_s, barrier_j. A mesh that is not closed, or a contact that does not lie at the rock, is a
// reject.
[[nodiscard]] Outcome fragility_files(const FragilityFiles& in, const std::filesystem::path& out, bool density_assumed,
                                      const fragility::FragilityOptions& options, base::RunContext& ctx);

// The recipe's stage: rocks/<id>.{ply,json}, segments.json -> rocks.json, rocks/<id>_tipping.{json,svg}.
// rocks.json also holds the targets that were not cut, with `rejected` and their reasons.
[[nodiscard]] std::unique_ptr<Stage> make_fragility_stage();

}  // namespace cairn::pipeline
