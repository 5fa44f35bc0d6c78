// Objects that may be rocks, without being told where.
#pragma once

#include <span>
#include <vector>

#include "geometry/vec.hpp"
#include "segmentation/candidates.hpp"
#include "segmentation/ground_filter.hpp"
#include "segmentation/plan_index.hpp"

namespace cairn::segmentation {

// find_candidates, touching ones parted (part_touching), without those that have no skin: whose points scatter about
// quadratic surfaces of 5 spacings reach more than 2.2 times as much as those of the ground around (shrubs, grass
// tufts; of simulated scenes shrubs have 3 to 4, rocks 1.0 to 1.5). Where there is too little to tell, it stays. index:
// of the same points.
[[nodiscard]] std::vector<Candidate> find_rocks(std::span<const geometry::Vec3> points,
                                                const GroundFilterResult& ground, const PlanIndex& index,
                                                const CandidateOptions& options);

}  // namespace cairn::segmentation
