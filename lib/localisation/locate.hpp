// Detections and poses to targets: the locate stage.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "base/reject.hpp"
#include "base/run_context.hpp"
#include "localisation/boxes.hpp"
#include "localisation/depth_prior.hpp"
#include "localisation/options.hpp"
#include "localisation/points.hpp"
#include "survey/survey.hpp"
#include "survey/target.hpp"

namespace cairn::localisation {

// What was measured of one target beside the record itself.
struct TargetEvidence {
  std::size_t boxes = 0;                                // consistent ones
  std::size_t visible_frames = 0;                       // frames that should show it whole; 0 = no centre to say by
  double rms_px = 0.0;                                  // of the box centres about the projected centre
  double parallax_deg = 0.0;                            // largest angle between two rays
  double size_m = 0.0;                                  // box diagonal at the target's distance, median
  geometry::Vec3 points_mean = geometry::Vec3::Zero();  // the filter's own estimate, m
  geometry::Mat3 points_covariance = geometry::Mat3::Zero();  // its spread, m^2
  geometry::Mat3 drift_covariance = geometry::Mat3::Zero();  // of the centre: what is left of the positions' drift, m^2
};

struct LocateCounts {
  std::size_t detections = 0;  // in the survey = used + rejected
  std::size_t used = 0;        // in a target's list
  std::size_t rejected = 0;
  std::size_t frames = 0;                                                      // with a usable pose
  std::size_t generated = 0, converging = 0, converged = 0, deregistered = 0;  // targets by final state
  std::size_t merged = 0, recovered = 0, moved_boxes = 0;                      // by the consensus (robust)
  std::size_t coasted = 0;                                                     // rows of tracks that are predictions
  std::size_t clock_jumps = 0;  // places where the frames' clock runs backwards
  double drift_m = 0.0;         // rms of the positions' slow errors that were found and removed (robust, video)
  double noise_scale = 1.0;     // factor that the residuals put on the assumed errors (robust)
  std::string depth_source;     // where the depth ranges come from
};

struct LocateResult {
  std::vector<survey::Target> targets;   // ascending id
  std::vector<TargetEvidence> evidence;  // one a target
  std::vector<Points> points;            // one a target; empty of deregistered ones
  // Of each used frame, in the order of the recording: recorded less true position as far as it wanders (drift.hpp), m.
  // The targets are those of the positions less this. Empty where no drift was sought.
  std::vector<std::pair<survey::FrameId, geometry::Vec3>> drift;
  std::vector<base::Reject> rejects;  // boxes and frames that were not used
  LocateCounts counts;
};

// mode paper: the points tracker over the frames in order; centre = mean of the points, covariance = their spread
//   (reason `covariance_is_spread`), state = what the filter reached.
// mode robust: the same with the corrected update; then consensus over all boxes, centre and covariance by robust
//   triangulation, and the filter run again over each target's final boxes for points, entropy, cylinder.
//   `history` says when the evidence for each stage was complete (history.hpp). Reasons say what is missing: seen_once,
//   too_few_boxes, one_direction, uncertain_centre, rarely_seen, inconsistent_boxes.
// Every detection is in exactly one target or among the rejects. Random numbers: (seed, "locate", target id).
// Nothing here needs frames to be near one another in time or space, nor tracks.
[[nodiscard]] LocateResult locate(const survey::Survey& survey, const LocateOptions& options, base::RunContext& ctx,
                                  const DepthBound& bound = nullptr);

// With tracks, only registered boxes go on (A5): those of the rows, see prepare_boxes. Both modes associate in space,
// so that an identity that the image tracker lost or switched does not tear a target apart; robust follows a track as
// long as its boxes fit the target.
[[nodiscard]] LocateResult locate(const survey::Survey& survey, const Tracks& tracks, const LocateOptions& options,
                                  base::RunContext& ctx, const DepthBound& bound = nullptr);

// The survey with the positions that the targets are relative to: recorded less `result.drift`.
[[nodiscard]] survey::Survey without_drift(survey::Survey survey, const LocateResult& result);

}  // namespace cairn::localisation
