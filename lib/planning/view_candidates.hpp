// Where views could stand that see again what was missed.
#pragma once

#include <span>
#include <vector>

#include "planning/clearance.hpp"
#include "planning/view_selection.hpp"
#include "survey/camera.hpp"
#include "survey/frame.hpp"

namespace cairn::planning {

struct CandidateOptions {
  double range_m = 0.0;      // of the views from what they look at; 0 = from the sampling distance of each demand
  double most_range_m = 50;  // where the sampling distance is not asked for, or would let views stand farther
  double cell_m = 1.0;       // demands of one cell and one facing (eight ways, or up) share their candidates
  double max_incidence_deg = 60.0;
  std::size_t max_candidates = 30000;  // cells grow until there are no more
};

struct ViewCandidate {
  geometry::Vec3 position = geometry::Vec3::Zero();
  double heading_deg = 0.0, pitch_deg = 0.0;
};

struct CandidateViews {
  std::vector<ViewCandidate> candidates;
  std::size_t too_low = 0;  // left out: closer to the surface than the clearance even when raised
  std::size_t unknown = 0;  // left out: over ground that is not known
  double cell_m = 0.0;      // used
  double farthest_m = 0.0;  // range used
};

// For each cell of demands: from its middle along 24 azimuths, elevations of 10 to 80 deg and straight up, at the range
// and at 0.6 of it, looking at the middle; kept where the mean normal is within max_incidence - 5 deg. Those too low
// are raised to the clearance where that keeps the incidence. Range from a sampling distance g: 0.6 g f, so that even
// at the largest incidence and off the axis it is met. Deterministic; ordered by cell.
[[nodiscard]] CandidateViews candidate_views(std::span<const Demand> demands, const survey::Camera& camera,
                                             const SurfaceHeights& surface, const ClearanceOptions& clearance,
                                             const CandidateOptions& options);

}  // namespace cairn::planning
