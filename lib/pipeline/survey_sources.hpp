// What a survey refers to outside its own tables: its cloud, and the list of all its files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/run_context.hpp"
#include "geometry/point_cloud.hpp"
#include "survey/survey.hpp"

namespace cairn::pipeline {

struct SurveyCloud {
  geometry::PointCloud cloud;  // local ENU of the survey, in the poses' frame, m
  std::filesystem::path path;
  std::string operation;  // how PROJ converted it, for run.json; "" where it was local already
};

// The survey's cloud in the poses' frame: CRS -> local ENU, then T_world_source where one is declared.
// This is the one place where a cloud's CRS is left behind.
// Throws not_found where the survey has no cloud or the file is missing, crs_mismatch where it
// declares no CRS and neither does the survey, invalid_input where it has no points or lies more than
// 20 km from the survey's origin. Warns where the heights have no declared datum.
// Cost: one pass; about 80 bytes a point.
[[nodiscard]] SurveyCloud load_cloud(const std::filesystem::path& survey_folder, const survey::Survey& survey,
                                     base::RunContext& ctx);

// Whether the survey names a cloud at all.
[[nodiscard]] bool has_cloud(const survey::Survey& survey);

// Every file the survey's content depends on: its tables, cloud and images; sorted, without repeats.
// Throws not_found naming the first that is missing, with the record that names it.
[[nodiscard]] std::vector<std::filesystem::path> survey_files(const std::filesystem::path& survey_folder,
                                                              const survey::Survey& survey);

}  // namespace cairn::pipeline
