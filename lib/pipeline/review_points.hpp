// Merging and splitting the labelled points of rocks. Internal to the stage `review`.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "geometry/point_cloud.hpp"
#include "pipeline/review_decisions.hpp"

namespace cairn::pipeline {

// Carries the changes out on column target_id, in order. Points of the rock: how many each reshaped rock has then.
// Throws invalid_input with the line where a rock has no points, or a seed gets none.
[[nodiscard]] std::map<std::int64_t, std::size_t> change_points(geometry::PointCloud& labelled, const ReviewPlan& plan,
                                                                const std::filesystem::path& edits_file);

// The cloud as if `rocks` were all that was found: points of other rocks lose label and id; terrain stays.
[[nodiscard]] geometry::PointCloud only_rocks(geometry::PointCloud labelled, const std::set<std::int64_t>& rocks);

}  // namespace cairn::pipeline
