// Every threshold of the locate stage, with where its default comes from.
#pragma once

#include <cstdint>
#include <string>

#include "base/options.hpp"

namespace cairn::localisation {

enum class Mode { paper, robust };

// "A" is the paper on mapping fragile geologic features (arXiv:2105.01287); "code" its public code.
// Values that differ between the modes are 0 here, meaning "as the mode has it"; `resolved` fills them in.
struct LocateOptions {
  std::string mode = "robust";  // paper: A to the letter, misprints corrected; robust: the corrected method

  // Boxes.
  double edge_margin_px = 5.0;  // boxes nearer to the image border are dropped (code: 5 px)
  double enlargement_px =
      0.0;  // each side, at generation; 0 = 30 px in paper (code: 10 px x 3), from pose and size in robust
  double duplicate_iou =
      0.7;                 // robust: of two boxes of one class in one frame that overlap more, the weaker is dropped
  double min_score = 0.0;  // detections below are dropped; 0 keeps all

  // Points (A, 2.4 to 2.7).
  std::int64_t points_per_target = 0;  // m; 0 = 1000 in paper (A's example), 2000 in robust (code)
  double min_depth_m = 0.0;            // depth range along camera z; 0, 0 = from the terrain or the tie points where
  double max_depth_m = 0.0;     //   there are any, else 3 m to 18 m (code, granite); paper draws from 0 to the far end
  double ground_up_m = -1.0e9;  // height of a level ground [local up], used instead of tie points; -1e9 = none
  double height_above_ground_m = 10.0;   // objects stand at most this high: near end of the depth range (ours)
  double noise_m = 0.1;                  // sqrt(sigma) of Algorithm 2, each axis, at every keyframe (code)
  double gaussian_weight = 0.2;          // w1 of (A.3) (code: 1 - epsilon)
  double uniform_weight = 0.8;           // w2 of (A.3) (code: epsilon)
  double entropy_converging_nats = 3.0;  // h_c: converging below it (code, granite)
  double divergence_converged = 0.01;    // KLD threshold (code)
  std::int64_t divergence_updates = 3;   // N_KLD (code)

  // Association and life cycle (A, 2.5, 2.6, 2.8).
  double min_points_fraction = 0.1;      // N_pts = m/10 (A)
  double mahalanobis_gate = 3.5;         // robust: box centre to projected points, sigmas (99.8 % in two dimensions)
  double keyframe_distance_m = 1.5;      // (code)
  double keyframe_angle_deg = 30.0;      // (code); yaw in paper, rotation angle in robust
  std::int64_t missing_iterations = 10;  // T_pts_missing (code: missed_hit_M)
  double target_spacing_m = 1.0;  // paper: a target that converges nearer to an earlier one is a duplicate (code)
  double size_ratio = 2.0;        // robust: largest ratio of sizes (box diagonal x depth) within a target

  // Final centre (robust).
  double sigma_px = 3.0;        // box centre, per axis, 1 sigma
  double sigma_size = 0.05;     // the same as a fraction of the box's mean side, added in square
  double outline_sigma = 0.03;  // middle of an outline to middle of the object, level, as a fraction of its size: added
                                //   to the centre's covariance (1.5 times that in height). Found on simulated rocks
  bool assumed_noise = false;   // keep these sigmas; else they are scaled by what the residuals of the whole survey say
  double pose_sigma_m = -1.0;   // 1 sigma of a camera position relative to its neighbours; -1 = what the frames say
  double pose_sigma_deg = -1.0;  // the same for its rotation
  double drift_time_s = 100.0;   // video: a position error that wanders changes by its own size in this time; it is
                                 //   estimated from the targets. 0 = do not
  double box_gate = 3.5;         // boxes farther from the projected centre [sigmas] are outliers
  std::int64_t generation_boxes = 0;  // robust: consistent boxes of a generated target; 0 = 2 from photographs
                                      //   (detections alone), 5 from tracks
  std::int64_t min_boxes = 3;         // consistent boxes of a converged target
  double min_hit_ratio = 0.34;        // of the frames that should show a target, the share that must, up to 8 frames;
  double min_hit_ratio_video = 0.5;   //   from 40 frames on; in between, in proportion
  double min_parallax_deg = 2.0;      // largest angle between two of its rays
  double max_sigma_m =
      0.5;  // largest standard deviation of a converged centre, any axis; a quarter of the size where that is more

  void visit(base::OptionVisitor& visitor);
};

[[nodiscard]] Mode mode_of(const LocateOptions& options);

// The options with the values of the mode filled in. tracks: the boxes are those of tracks. Validates; throws
// invalid_argument.
[[nodiscard]] LocateOptions resolved(LocateOptions options, bool tracks = false);

}  // namespace cairn::localisation
