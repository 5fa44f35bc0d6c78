#include "localisation/options.hpp"

#include "base/error.hpp"

namespace cairn::localisation {
namespace {

constexpr std::int64_t kPaperPoints = 1000, kRobustPoints = 2000;
constexpr double kPaperEnlargementPx = 30.0;
constexpr std::int64_t kPhotoBoxes = 2, kTrackBoxes = 5;

}  // namespace

void LocateOptions::visit(base::OptionVisitor& v) {
  v.choice("mode", mode, {"paper", "robust"}, "paper: the published method to the letter; robust: the corrected one");
  v.real("edge-margin-px", edge_margin_px, 0.0, 1e4, "drop boxes nearer to the image border than this");
  v.real("enlargement-px", enlargement_px, 0.0, 1e4, "enlarge a new target's box by this on each side; 0 = by mode");
  v.real("duplicate-iou", duplicate_iou, 0.0, 1.0, "drop the weaker of two boxes of one class that overlap more");
  v.real("min-score", min_score, 0.0, 1.0, "drop detections with a lower score");
  v.integer("points-per-target", points_per_target, 0, 1000000, "points per target; 0 = 1000 in paper, 2000 in robust");
  v.real("min-depth-m", min_depth_m, 0.0, 1e5, "nearest depth of an object; 0 = from terrain or tie points");
  v.real("max-depth-m", max_depth_m, 0.0, 1e5, "farthest depth of an object; 0 = from terrain or tie points");
  v.real("ground-up-m", ground_up_m, -1e9, 1e5, "height of level ground, local up; -1e9 = not given");
  v.real("height-above-ground-m", height_above_ground_m, 0.0, 1e3, "greatest height of an object");
  v.real("noise-m", noise_m, 0.0, 1e3, "noise added to the points at each keyframe, 1 sigma per axis");
  v.real("gaussian-weight", gaussian_weight, 0.0, 1.0, "share of the Gaussian in a point's weight");
  v.real("uniform-weight", uniform_weight, 0.0, 1.0, "share of the uniform density in a point's weight");
  v.real("entropy-converging-nats", entropy_converging_nats, -100.0, 100.0, "converging below this entropy");
  v.real("divergence-converged", divergence_converged, 0.0, 1e6, "divergence below which an update counts as settled");
  v.integer("divergence-updates", divergence_updates, 1, 1000, "settled updates in a row that make a target converged");
  v.real("min-points-fraction", min_points_fraction, 0.0, 1.0, "share of the points that must fall into a box");
  v.real("mahalanobis-gate", mahalanobis_gate, 0.0, 100.0, "gate between box centre and projected points, sigmas");
  v.real("keyframe-distance-m", keyframe_distance_m, 0.0, 1e4, "camera movement that makes a keyframe");
  v.real("keyframe-angle-deg", keyframe_angle_deg, 0.0, 180.0, "camera rotation that makes a keyframe");
  v.integer("missing-iterations", missing_iterations, 1, 1000000, "misses in a row that deregister a target");
  v.real("target-spacing-m", target_spacing_m, 0.0, 1e4, "paper: converged targets nearer than this are duplicates");
  v.real("size-ratio", size_ratio, 1.0, 100.0, "largest ratio of object sizes within one target");
  v.real("sigma-px", sigma_px, 0.01, 1e3, "1 sigma of a box centre");
  v.real("sigma-size", sigma_size, 0.0, 1.0, "1 sigma of a box centre as a fraction of the box's side");
  v.real("outline-sigma", outline_sigma, 0.0, 1.0,
         "1 sigma between an outline's middle and the object's, as a fraction of the size");
  v.flag("assumed-noise", assumed_noise, "keep the assumed errors instead of scaling them to the residuals");
  v.real("pose-sigma-m", pose_sigma_m, -1.0, 1e3, "1 sigma of a camera position; -1 = as the frames say");
  v.real("pose-sigma-deg", pose_sigma_deg, -1.0, 180.0, "1 sigma of a camera rotation; -1 = as the frames say");
  v.real("drift-time-s", drift_time_s, 0.0, 1e6,
         "video: time in which a wandering position error changes by its size; 0 = do not estimate it");
  v.real("box-gate", box_gate, 0.1, 100.0, "boxes farther from the projected centre are outliers, sigmas");
  v.integer("min-boxes", min_boxes, 2, 1000, "consistent boxes of a converged target");
  v.integer("generation-boxes", generation_boxes, 0, 100000,
            "consistent boxes of a generated target; 0 = 2 from detections, 5 from tracks");
  v.real("min-hit-ratio-video", min_hit_ratio_video, 0.0, 1.0,
         "the same where 40 frames and more should show the target");
  v.real("min-hit-ratio", min_hit_ratio, 0.0, 1.0,
         "least share of the frames that should show a target and do, up to 8 of them");
  v.real("min-parallax-deg", min_parallax_deg, 0.0, 180.0, "least angle between two rays of a converged target");
  v.real("max-sigma-m", max_sigma_m, 0.0, 1e4, "largest standard deviation of a converged centre");
}

Mode mode_of(const LocateOptions& options) {
  return options.mode == "paper" ? Mode::paper : Mode::robust;
}

LocateOptions resolved(LocateOptions options, bool tracks) {
  base::validate(base::bind_options(options), "locate");
  if (options.max_depth_m > 0.0 && !(options.max_depth_m > options.min_depth_m))
    throw base::Error(base::ErrorCode::invalid_argument, "options of locate: max-depth-m must exceed min-depth-m")
        .found(std::to_string(options.max_depth_m))
        .allowed("more than " + std::to_string(options.min_depth_m));
  if (!(options.gaussian_weight + options.uniform_weight > 0.0))
    throw base::Error(base::ErrorCode::invalid_argument,
                      "options of locate: gaussian-weight and uniform-weight are both 0")
        .hint("Give at least one of them a positive value");
  const bool paper = mode_of(options) == Mode::paper;
  if (options.points_per_target == 0) options.points_per_target = paper ? kPaperPoints : kRobustPoints;
  if (options.enlargement_px == 0.0 && paper) options.enlargement_px = kPaperEnlargementPx;
  if (options.generation_boxes == 0) options.generation_boxes = tracks ? kTrackBoxes : kPhotoBoxes;
  return options;
}

}  // namespace cairn::localisation
