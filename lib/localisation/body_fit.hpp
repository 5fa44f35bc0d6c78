// Joint refinement: one body fitted to all boxes of a target at once, after the filter.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "localisation/locate.hpp"
#include "survey/survey.hpp"
#include "survey/target.hpp"

namespace cairn::localisation {

struct BodyFitOptions {
  double edge_margin_px = 5.0;  // box sides nearer to the image border are where the image was cut: not used
  double sigma_px = 3.0;        // 1 sigma of a box side
  double sigma_size = 0.05;     // the same as a fraction of the box's mean side, added in square
  bool assumed_noise = false;   // keep these sigmas; else they are scaled by what the residuals of the whole survey say
  double pose_sigma_m = -1.0;   // 1 sigma of a camera position; -1 = what the frames say
  double pose_sigma_deg = -1.0;  // the same for its rotation
  // Share of the rotations' sigma that all frames of an object have in common (a mount that is not quite straight): of
  // photos. A long video tells by itself.
  double common_turn = 0.25;
  double loss_scale = 3.65;       // whitened norm of a box's four residuals at which it has half its weight (99 %)
  std::string shape = "rock";     // rock: ellipsoid corrected by harmonics as rocks have them; ellipsoid: none
  double margin_sigmas = 1.5;     // the cylinder is this much wider and taller than the most likely one
  std::int64_t max_boxes = 400;   // of more, this many are used, evenly along the time
  std::int64_t min_boxes = 3;     // from different frames, two of them whole
  double min_parallax_deg = 2.0;  // largest angle between two of its rays

  void visit(base::OptionVisitor& visitor);
};

struct BodyFitCounts {
  std::size_t fitted = 0, failed = 0;  // of the converged and mapped targets
  std::size_t boxes = 0, rejected_boxes = 0;
  double box_noise_scale = 1.0;   // factor that the residuals put on the sides' sigma
  double pose_noise_scale = 1.0;  // the same on the poses' sigmas
};

// Fills `refined` of every converged or mapped target from its `detections`, or adds a reason: fit_too_few_boxes,
// fit_one_direction, fit_behind_camera, fit_not_converged, fit_singular.
BodyFitCounts refine_bodies(std::vector<survey::Target>& targets, const survey::Survey& survey,
                            const BodyFitOptions& options, base::RunContext& ctx);

// The same for what `locate` found in `survey`: the boxes are seen from the positions less their drift, and what is
// left of the drift is part of each body's covariance.
BodyFitCounts refine_bodies(LocateResult& located, const survey::Survey& survey, const BodyFitOptions& options,
                            base::RunContext& ctx);

}  // namespace cairn::localisation
