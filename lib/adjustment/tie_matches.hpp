// Tie points from the images of a survey whose poses are only roughly known.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "adjustment/two_view.hpp"
#include "base/options.hpp"
#include "base/reject.hpp"
#include "base/run_context.hpp"
#include "geometry/grey_image.hpp"
#include "survey/survey.hpp"

namespace cairn::adjustment {

struct TieMatchOptions {
  std::int64_t max_width_px = 1600;    // images wider than this are shrunk first
  std::int64_t max_features = 8000;    // strongest kept per image
  std::int64_t first_features = 2000;  // of them, matched by descriptors alone; the rest where the poses then say
  bool guided = true;                  // match again with all features once the poses agree roughly
  double ratio = 0.8;                  // Lowe's ratio
  std::int64_t all_pairs_up_to = 24;   // surveys with no more images: every pair is a candidate
  std::int64_t neighbours = 16;        // larger ones: each image with its nearest, and
  std::int64_t successors = 3;         // with those that follow it
  double position_slack_m = 5.0;       // added to the reach of two images' footprints
  double epipolar = 0.003;             // distance from the epipolar line of a consistent match [focal lengths]
  std::int64_t min_inliers = 20;       // pairs with fewer consistent matches are left out
  std::int64_t min_track = 2;          // images a tie point must be seen in
  double max_residual = 0.004;         // of an observation after the rough alignment, at least [focal lengths]
  double min_angle_deg = 1.0;          // between the rays of a tie point
  bool turn_frames = true;             // undo turns of the raster by 90, 180, 270 degrees where there is evidence

  void visit(base::OptionVisitor& v) {
    v.integer("match-max-width-px", max_width_px, 200, 20000, "images are shrunk to this width before matching [px]");
    v.integer("match-max-features", max_features, 100, 100000, "strongest features kept per image");
    v.integer("match-first-features", first_features, 100, 100000, "strongest features, matched by descriptors alone");
    v.flag("match-guided", guided, "match all features again where the roughly aligned poses say");
    v.real("match-ratio", ratio, 0.1, 1.0, "largest ratio of best to second-best descriptor distance");
    v.integer("match-all-pairs-up-to", all_pairs_up_to, 0, 10000, "up to this many images every pair is tried");
    v.integer("match-neighbours", neighbours, 1, 1000, "nearest images each image of a larger survey is matched with");
    v.integer("match-successors", successors, 0, 1000, "following images each image is matched with");
    v.real("match-position-slack-m", position_slack_m, 0.0, 10000.0, "added to the reach of two footprints [m]");
    v.real("match-epipolar", epipolar, 0.0001, 0.1,
           "distance from the epipolar line of a consistent match [focal lengths]");
    v.integer("match-min-inliers", min_inliers, 8, 100000, "pairs with fewer consistent matches are left out");
    v.integer("match-min-track", min_track, 2, 100, "images a tie point must be seen in");
    v.real("match-max-residual", max_residual, 0.0001, 0.5,
           "largest residual of an observation after the rough alignment [focal lengths]");
    v.real("match-min-angle-deg", min_angle_deg, 0.01, 60.0, "least angle between the rays of a tie point [deg]");
    v.flag("match-turn-frames", turn_frames, "undo turns of the raster where neighbouring images give evidence");
  }
};

// The brightness of a frame's image, of any size with the camera's proportions. Throws base::Error where it cannot be
// read: the frame is then rejected. Called from several threads at once.
using ImageLoader = std::function<geometry::GreyImage(const survey::Frame&)>;

struct TiePair {
  survey::FrameId a, b;
  std::size_t matched = 0;     // by descriptors
  std::size_t consistent = 0;  // with one rigid scene
  TwoViewModel model = TwoViewModel::none;
  std::string reason;  // "" = used; "too_few_matches", "inconsistent"
};

// A frame whose raster was turned after the exposure, with what says so: the disagreement on the ground of its matches
// with its neighbours, as declared and with the turn undone.
struct TurnedFrame {
  survey::FrameId frame;
  int turned_deg = 0;  // 90, 180, 270, clockwise
  double before_m = 0.0, after_m = 0.0;
  std::size_t pairs = 0;  // that bear witness
};

struct MatchedTies {
  std::vector<survey::TiePoint> ties;  // ids from 1, in the order of their first observation; p_world by `start`
  std::vector<survey::Frame> frames;   // the survey's frames with turned headings put right: priors
  std::vector<survey::Frame> start;    // the same aligned with the ties: a start for bundle adjustment
  std::vector<TurnedFrame> turned;
  std::vector<TiePair> pairs;                  // all candidates, ascending
  std::vector<survey::FrameId> unmatched;      // frames without a tie point
  std::vector<base::Reject> rejects;           // images, and tie points by reason (one reject a reason and its count)
  std::size_t features = 0, observations = 0;  // found; in `ties`
  double ground_up_m = 0.0;                    // local up of the ground, median over pairs; with ground_known
  bool ground_known = false;
  double median_residual_px = 0.0;  // after the rough alignment, in pixels of the frames' cameras
};

// SIFT of every image; candidate pairs by position (all pairs for small surveys), thinned by the reach of the
// footprints once the nearest pairs have told the height of the ground; ratio test both ways; verify_two_views; turned
// frames by pair_evidence; tracks without conflicts; rough alignment (align_roughly); guided matching of all features,
// tracks and alignment again; gates for cheirality, angle and residual. Poses may be off by metres and several degrees,
// headings by a turned raster. A turn is undone as a roll about the optical axis: exact for a principal point at the
// image centre and distortion without tangential terms; for others the camera must be mirrored by the caller. Limits:
// rays within 75 degrees of the optical axis; turns are found only over roughly level ground seen from above. The same
// result for any number of threads. Memory: 144 bytes a feature; a thread holds one image, or 3 kB a feature of one
// image for the pair it matches. Cost: about 0.6 s an image of 1600 x 900 and 0.15 s a pair on one core.
[[nodiscard]] MatchedTies match_ties(const survey::Survey& rough, const ImageLoader& load,
                                     const TieMatchOptions& options, base::RunContext& ctx);

}  // namespace cairn::adjustment
