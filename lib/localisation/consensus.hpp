// From the tracker's targets to targets that agree with all boxes: outliers out, duplicates merged, what was
// torn apart put together.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "localisation/boxes.hpp"
#include "localisation/depth_prior.hpp"
#include "localisation/options.hpp"
#include "localisation/tracker.hpp"
#include "localisation/triangulation.hpp"

namespace cairn::localisation {

// A target with at least two boxes that meet in one point.
struct Candidate {
  survey::TargetId id;
  std::size_t object_class = 0;
  std::vector<std::size_t> boxes;  // indices into PreparedBoxes::boxes, ascending, all consistent, one a frame
  Triangulation fix;
  // What slow errors of the poses, and the outline's middle not being the object's, add to the fix's, m^2.
  geometry::Mat3 common_covariance = geometry::Mat3::Zero();
  geometry::Mat3 drift_covariance = geometry::Mat3::Zero();  // the part of it that is drift of the positions
  double size_m = 0.0;                                       // box diagonal x depth / focal length, median
  std::size_t visible_frames = 0;                            // frames that should show the whole object
};

struct Consensus {
  std::vector<Candidate> candidates;                 // ascending id
  std::vector<std::size_t> left_over;                // boxes of no candidate, ascending
  std::vector<survey::TargetId> seed_of_box;         // the tracker's target of each box; invalid for cut boxes
  std::size_t merged = 0, recovered = 0, moved = 0;  // targets merged, targets found among the left-over boxes,
                                                     //   boxes that changed their target
};

// Steps, until nothing changes (at most 5 rounds):
//   1. triangulate each target's boxes robustly; boxes that do not fit go to the pool;
//   2. join targets of one class that share no frame and whose boxes together still meet in one point;
//   3. among the pool's boxes, take the point that most boxes agree with (from all pairs of rays, in the
//      depth range and of like size), again and again;
//   4. assign all boxes to all targets anew, frame by frame, by reprojection distance (Hungarian).
// A box belongs to one target at most. Cost: targets x frames, plus pairs of pool boxes whose depth
// ranges overlap on the map.
// How much larger the residuals are than the assumed errors say: sqrt(sum of squared residuals [sigmas] / redundancy)
// over the targets with three or more whole boxes. Empty with a redundancy below 50: too little to judge by.
[[nodiscard]] std::optional<double> noise_scale(const PreparedBoxes& prepared, const Consensus& consensus);

[[nodiscard]] Consensus find_consensus(const PreparedBoxes& prepared, const DepthPrior& depth,
                                       const std::vector<LiveTarget>& seeds, const LocateOptions& options,
                                       const base::RunContext& ctx);

}  // namespace cairn::localisation
