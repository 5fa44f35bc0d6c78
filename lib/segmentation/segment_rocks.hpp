// Rocks of a cloud, each by what the cloud shows of it: by the crease at its foot where the cloud is dense enough to
// show one, else by height above the ground (rock_cut.hpp).
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "geometry/point_cloud.hpp"
#include "segmentation/candidates.hpp"
#include "segmentation/rock_cut.hpp"
#include "segmentation/rock_patch.hpp"

namespace cairn::segmentation {

struct SegmentRocksOptions {
  std::string method = "auto";          // auto, crease or height
  double dense_height_spacings = 15.0;  // auto: the crease is sought where the rock is this many spacings high
  RockCutOptions cut;
  RockPatchOptions patch;

  void visit(base::OptionVisitor& visitor);
};

// What a person says about a rock; takes precedence over what is found.
struct RockGuidance {
  std::vector<RockPick> picks;                       // wherever they lie
  std::map<std::int64_t, survey::Contact> contacts;  // by target id; digitised
};

// As cut_rocks; targets by ascending id, points that two of them claim go to the lower id, and a rock most of whose
// points are taken is rejected as duplicate_of_target. Reasons beside those of cut_rocks: two_points, planar,
// not_a_surface. Where the crease was sought and not found the rock is cut by height, with the note no_contact.
// Parallel over targets.
[[nodiscard]] RockCuts segment_rocks(const geometry::PointCloud& cloud, const std::vector<RockTarget>& targets,
                                     const RockGuidance& guidance, const SegmentRocksOptions& options,
                                     base::RunContext& ctx);

// Targets where objects stand out of the ground (filter_ground, find_candidates), ids from 1.
[[nodiscard]] std::vector<RockTarget> find_rock_targets(const geometry::PointCloud& cloud, base::RunContext& ctx);

}  // namespace cairn::segmentation
