// Is there a cloud, can it be read, and does it lie where the survey is?
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "geometry/point_cloud.hpp"
#include "io/json.hpp"
#include "pipeline/check_findings.hpp"
#include "pipeline/check_options.hpp"
#include "pipeline/check_tables.hpp"

namespace cairn::pipeline {

struct CheckedCloud {
  geometry::PointCloud cloud;  // local ENU, T_world_source applied
  std::filesystem::path path;
  bool has_similarity = false;
};

// The cloud where it can be used, else nothing. Codes: cloud_missing, cloud_unreadable, cloud_empty,
// cloud_no_crs, cloud_crs_invalid, cloud_units_contradict, cloud_no_vertical_datum, cloud_in_feet,
// cloud_heights_in_feet, cloud_heights_differ, cloud_wrong_crs, cloud_far_from_survey, cloud_no_colours,
// cloud_file_note.
//
// A cloud that is not near the survey is tried again read in feet, with heights in feet, as another UTM
// zone, as latitude and longitude, and with its axes swapped; what puts it there is named.
[[nodiscard]] std::optional<CheckedCloud> check_cloud(const CheckedSurvey& checked, const std::filesystem::path& folder,
                                                      const CheckOptions& options, Findings& findings,
                                                      io::Json& evidence);

}  // namespace cairn::pipeline
