// A point cloud by itself as a survey: no photographs, no detections.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "geometry/geodetic.hpp"

namespace cairn::pipeline {

// Writes survey.json and an empty frames.csv into `folder`, which refer to the cloud. The origin is the centre of the
// cloud's bounds on whole metres; heights are ellipsoidal where the cloud's CRS has a vertical part, else unknown. A
// cloud without CRS is taken as local metres about `origin`.
// Throws crs_mismatch where the cloud declares no CRS and no origin is given, invalid_input where it has no points.
void write_cloud_survey(const std::filesystem::path& cloud, const std::optional<geometry::Geodetic>& origin,
                        const std::filesystem::path& folder);

// "46.84,-91.99,158" -> position. Throws invalid_argument.
[[nodiscard]] geometry::Geodetic parse_origin(std::string_view text);

}  // namespace cairn::pipeline
