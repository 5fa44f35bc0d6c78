// Do the tie points reproject where they were seen? And if not: which misreading explains it?
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/options.hpp"
#include "geometry/vec.hpp"
#include "survey/survey.hpp"

namespace cairn::adjustment {

struct TieEvidenceOptions {
  double max_median_px = 5.0;           // a frame whose median error is larger is bad
  std::int64_t min_observations = 8;    // frames with fewer are not judged
  std::int64_t max_observations = 300;  // used per frame and hypothesis; more are thinned evenly
  double half_pixel_tolerance_px = 0.15;

  void visit(base::OptionVisitor& v) {
    v.real("max-median-px", max_median_px, 0.1, 1000.0, "largest sound median reprojection error of a frame [px]");
    v.integer("min-observations", min_observations, 3, 100000, "frames with fewer tie observations are not judged");
    v.integer("max-observations", max_observations, 10, 1000000, "tie observations tried per frame and hypothesis");
    v.real("half-pixel-tolerance-px", half_pixel_tolerance_px, 0.01, 0.24,
           "how near to half a pixel a constant shift must be to be named so [px]");
  }
};

struct FrameReprojection {
  survey::FrameId frame;
  std::size_t observations = 0;
  std::size_t behind = 0;                             // points behind the camera, or that cannot be projected
  double median_px = 0.0;                             // distance observed - projected; infinite when most are behind
  geometry::Vec2 bias_px = geometry::Vec2::Zero();    // medians of observed - projected
  geometry::Vec2 spread_px = geometry::Vec2::Zero();  // robust sigmas of the same
  bool judged = false;                                // enough observations
};

// One misreading that explains a set of frames.
struct TieVerdict {
  std::string code;  // "pose_inverted", "quaternion_order_xyzw", "frame_turned_180", "image_scale", "half_pixel_shift"
  std::vector<survey::FrameId> frames;
  double before_px = 0.0, after_px = 0.0;  // medians of the frames' medians
  std::string meaning, remedy;
  double scale = 1.0;  // with image_scale: pixels of the observations / of the camera
};

struct TieEvidence {
  std::size_t points = 0, observations = 0;
  double median_px = 0.0;                    // over all observations, as declared; infinite when most are behind
  std::vector<FrameReprojection> frames;     // frames with at least one observation, by id
  std::vector<TieVerdict> verdicts;          // none where the survey is sound
  std::vector<survey::FrameId> unexplained;  // bad frames that no hypothesis explains
};

// Hypotheses are tried frame by frame against the common points; one explains a frame when it brings the
// median below max_median_px (or, where the points themselves are coarse, to a tenth). The hypothesis
// that explains most bad frames is named, then the next for those left over.
// Observations are checked only against frames and cameras that exist; others are ignored here.
// Cost: hypotheses (75) * max_observations projections for each bad frame.
[[nodiscard]] TieEvidence tie_evidence(const survey::Survey& survey, const TieEvidenceOptions& options = {});

}  // namespace cairn::adjustment
