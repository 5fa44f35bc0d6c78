// Do neighbouring images show the same ground where the poses say they should? Needs no tie points:
// the matches of two images are laid on a common plane through the poses, and must coincide there.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "adjustment/feature_matches.hpp"
#include "base/options.hpp"
#include "survey/survey.hpp"

namespace cairn::adjustment {

struct PairEvidenceOptions {
  double min_height_m = 1.0;  // allowed heights of the cameras above the ground plane
  double max_height_m = 500.0;
  double min_baseline_m = 2.0;    // closer cameras cannot tell a turned pair from a sound one
  double max_sound_ratio = 0.35;  // ground disagreement / base line up to which a pair is sound
  std::int64_t max_matches = 80;  // used per pair; more are thinned evenly
  std::int64_t neighbours = 4;    // pairs proposed per frame

  void visit(base::OptionVisitor& v) {
    v.real("pair-min-height-m", min_height_m, 0.1, 1e4, "least height of a camera above the ground plane [m]");
    v.real("pair-max-height-m", max_height_m, 1.0, 1e5, "largest height of a camera above the ground plane [m]");
    v.real("pair-min-baseline-m", min_baseline_m, 0.01, 1e4, "camera pairs closer than this are not used [m]");
    v.real("pair-max-sound-ratio", max_sound_ratio, 0.05, 0.9,
           "largest ground disagreement of a sound pair as a fraction of its base line");
    v.integer("pair-max-matches", max_matches, 10, 100000, "matches used per pair");
    v.integer("pair-neighbours", neighbours, 1, 100, "neighbours each frame is matched with");
  }
};

// Indices into survey.frames: each frame with its nearest neighbours at min_baseline_m or more, a < b,
// ascending, without doubles. Cost n^2 for n frames.
[[nodiscard]] std::vector<std::pair<std::size_t, std::size_t>> neighbour_pairs(const survey::Survey& survey,
                                                                               const PairEvidenceOptions& options = {});

struct MatchedPair {
  survey::FrameId a, b;
  std::vector<PixelMatch> matches;  // px of the frames' cameras
};

struct PairFigures {
  survey::FrameId a, b;
  std::size_t matches = 0;
  double baseline_m = 0.0;
  double declared_m = 0.0;   // median disagreement on the ground with the poses as declared, best plane; inf = no plane
  double corrected_m = 0.0;  // the same with the verdicts applied
  double plane_up_m = 0.0;   // local up of the plane, with the verdicts applied
  double turn_deg = 0.0;     // rotation of image a against b that the poses do not explain, -180..180, as declared
};

// What explains the pairs. `frames` is every frame where the convention of the whole survey is wrong.
struct PairVerdict {
  std::string code;  // "frame_turned_180", "frame_turned_90", "frame_turned_270", "pose_inverted", ...
  std::vector<survey::FrameId> frames;
  double before_m = 0.0, after_m = 0.0;  // median ground disagreement of the frames' pairs
  std::string meaning, remedy;
};

struct PairEvidence {
  std::vector<PairFigures> pairs;  // those that could be used
  std::vector<PairVerdict> verdicts;
  std::vector<survey::FrameId> unexplained;  // frames most of whose pairs stay bad
  std::vector<survey::FrameId> unmatched;    // frames without a usable pair
};

// For two cameras above a plane at height z the matches m_a, m_b meet the plane at
//   X = C_xy + (C_z - z) d,  d = ray_xy / -ray_z,
// so X_a - X_b is linear in z and z is found by reweighted least squares (L1), within the heights
// allowed. With both rasters turned by 180 degrees d changes sign in both, which would fit as well with
// a plane above the cameras: the direction of the base line against that of the features tells the two
// apart. Each frame's turn (0, 90, 180, 270) is found by iterated conditional modes over all pairs,
// started from the pairs' own votes. When turns alone leave most pairs bad, the hypotheses of
// pose_hypotheses() are tried on all frames at once.
// Limits: ground roughly level within an image, base lines well above the error of the positions,
// attitudes better than about 15 degrees. Cost: 16 fits a pair.
[[nodiscard]] PairEvidence pair_evidence(const survey::Survey& survey, std::span<const MatchedPair> matched,
                                         const PairEvidenceOptions& options = {});

}  // namespace cairn::adjustment
