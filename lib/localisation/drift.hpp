// Slow errors of the recorded positions - a GPS that wanders by metres between two lanes - found from the targets that
// were seen on both.
#pragma once

#include <cstddef>
#include <vector>

#include "localisation/boxes.hpp"
#include "localisation/consensus.hpp"
#include "localisation/options.hpp"

namespace cairn::localisation {

struct Drift {
  std::vector<geometry::Vec3> offset_m;    // a frame: recorded less true position, mean over the frames 0; local ENU
  std::vector<double> sigma_m;             // a frame: how well that is known, rms of the three axes
  std::vector<geometry::Mat3> covariance;  // a candidate: what is left of the drift in its centre, m^2
  double rms_m = 0.0;                      // of the offsets
};

// Whether there is anything to gain: a video, positions stated to be wrong by 0.05 m or more, drift_time_s > 0.
[[nodiscard]] bool drifts(const PreparedBoxes& prepared, const LocateOptions& options);

// Least squares over the candidates' boxes, jointly in the candidates' centres and in an offset of the positions that
// is linear between nodes (every 5 s or more, 200 at most); Huber's loss, three Gauss-Newton steps. Prior: each offset
// normal with the frames' stated sigma s, its change a random walk that reaches s in drift_time_s, or a share of that
// (0.01, 0.03, 0.1, 0.3), whichever makes the boxes most likely. The boxes of one
// candidate between two nodes count as three at most: their errors are not independent. What all positions have in
// common cannot be known from boxes: it stays in the centres (mean offset 0).
// Cost: boxes + nodes^3.
[[nodiscard]] Drift estimate_drift(const PreparedBoxes& prepared, const std::vector<Candidate>& candidates,
                                   const LocateOptions& options);

// Takes the offsets out of the frames' poses; their sigmas become those of what is left.
void remove_drift(const Drift& drift, PreparedBoxes& prepared);

}  // namespace cairn::localisation
