// When a target of mode robust entered its stages: what the boxes up to then say.
#pragma once

#include <cstddef>
#include <vector>

#include "localisation/boxes.hpp"
#include "localisation/consensus.hpp"
#include "localisation/options.hpp"
#include "localisation/tracker.hpp"
#include "survey/target.hpp"

namespace cairn::localisation {

// The share of the frames that should show a target in which it must be boxed: min_hit_ratio while these frames are
// few (photographs), rising to min_hit_ratio_video as they become many.
[[nodiscard]] double least_hit_ratio(const LocateOptions& options, std::size_t visible_frames);

// Largest standard deviation [m] of a converged centre of an object of this size.
[[nodiscard]] double largest_sigma(const LocateOptions& options, double size_m);

struct Stages {
  std::vector<survey::StageEntry> history;
  bool rare = false;                 // in the end too few of the frames that should show it do
  std::vector<std::string> missing;  // reasons why it is not converged; empty = it is
};

// Walks over the target's boxes in the order of the frames, with what is known by then: boxes, frames that should have
// shown it, angle between its rays, covariance of its centre, entropy of its points. (Which boxes are its own, and
// where it is, come from the whole recording.)
//   generated:  enough boxes (generation_boxes) and hits;
//   converging: generated, and the entropy of the points below the threshold;
//   converged:  generated, min_boxes, parallax, sigma, hits - whatever the entropy says.
// A target that is given up in the end has `deregistered` as its last entry. Cost linear in frames and boxes.
// live: the filter over the candidate's whole boxes. Frames must hold the poses that gave the candidate's fix.
[[nodiscard]] Stages stages_of(const PreparedBoxes& prepared, const Candidate& candidate, const LiveTarget& live,
                               const LocateOptions& options);

}  // namespace cairn::localisation
