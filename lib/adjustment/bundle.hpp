// Bundle adjustment: poses, points and (on request) intrinsics that explain where the points were seen.
//
// Minimises  sum rho(|pixel - project|^2 / sigma_px^2) + priors of the poses + control points
// by Levenberg-Marquardt on the Schur complement (Triggs et al. 2000, "Bundle Adjustment - A Modern Synthesis",
// sections 4, 6; Agarwal et al., Ceres Solver), one thread a problem, with analytic Jacobians for every camera model.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "adjustment/bundle_options.hpp"
#include "base/reject.hpp"
#include "base/run_context.hpp"
#include "geometry/rigid_transform.hpp"
#include "survey/camera.hpp"
#include "survey/control_point.hpp"
#include "survey/frame.hpp"
#include "survey/tie_point.hpp"

namespace cairn::adjustment {

using Mat6 = Eigen::Matrix<double, 6, 6>;

// What is to be adjusted: records of a survey, by value or cut from one.
struct BundleProblem {
  std::vector<survey::Camera> cameras;
  // Ascending id. The poses are the priors where sigmas are given, and the start.
  std::vector<survey::Frame> frames;
  // Per frame, another start (T_world_camera) than its own pose; empty = their own.
  std::vector<geometry::RigidTransform> start;
  // Ascending id. p_world is used as BundleOptions::triangulate says; it may be anything, not a number too.
  std::vector<survey::TiePoint> ties;
  std::vector<survey::ControlPoint> control;
};

// What happened to one frame.
struct BundleFrame {
  survey::FrameId frame;
  std::string reason;            // "" = adjusted; "too_few_observations", "not_connected", "no_datum" = kept its pose
  std::size_t observations = 0;  // used
  std::size_t outliers = 0;      // removed
  // Of the observations used: before = the frames' poses and the points triangulated from them.
  double rms_before_px = 0.0, rms_after_px = 0.0;
  double moved_m = 0.0, turned_deg = 0.0;  // from the frame's pose (after alignment where the gauge was free)
  double prior_sigmas = 0.0;               // distance from its prior [sigmas, of its given components]; 0 without one
  bool prior_doubted = false;              // beyond the prior's loss scale: the prior was held loosely
  // Of (rotation in camera axes [rad], position in the world [m]); zero where it was not computed.
  Mat6 covariance = Mat6::Zero();
};

// One solve.
struct BundleRound {
  std::int64_t iterations = 0;
  double cost_before = 0.0, cost_after = 0.0;  // half the sum of squares, losses applied, in sigma units
  double sigma_px = 0.0;                       // of the tie observations, as assumed in this round
  std::size_t observations = 0, removed = 0;   // used in it; removed after it
  bool converged = false;                      // a tolerance was reached, not a limit
  std::string termination;                     // the solver's sentence
};

// One control or check point.
struct BundleControl {
  std::string name;
  bool check_only = false;
  std::string reason;  // "" = used; "not_seen" (no usable observation), "seen_once" (a check point needs two)
  std::size_t observations = 0;
  geometry::Vec3 before = geometry::Vec3::Zero();  // triangulated - surveyed, frames' poses, m
  geometry::Vec3 after = geometry::Vec3::Zero();   // the same, adjusted poses (a control point: adjusted - surveyed)
  double rms_px = 0.0;                             // after
};

// How the seven degrees of freedom that pixels leave open were fixed.
enum class BundleGauge {
  priors,   // the frames' priors, control points too where there are any
  control,  // at least three control points that are not in line
  aligned,  // nothing fixed them: the result was aligned by a similarity to the start positions
};
[[nodiscard]] std::string_view name_of(BundleGauge gauge);

struct BundleResult {
  std::vector<survey::Camera> cameras;
  // All frames of the problem. Sigmas are a-posteriori where they were computed; with BundleGauge::priors and full
  // covariances they are those of the frames against one another (no common similarity; frame_reports has both).
  std::vector<survey::Frame> frames;
  std::vector<survey::TiePoint> ties;      // points used, with the observations used, ascending id
  std::vector<BundleFrame> frame_reports;  // as frames
  std::vector<BundleControl> control;
  std::vector<BundleRound> rounds;
  BundleGauge gauge = BundleGauge::aligned;
  geometry::Similarity alignment;  // with BundleGauge::aligned: what was applied at the end
  bool converged = false;
  double sigma_px = 0.0;                           // of the tie observations, estimated from the residuals (1.4826 MAD)
  double rms_before_px = 0.0, rms_after_px = 0.0;  // over all observations used
  std::size_t points = 0, observations = 0;        // used
  std::size_t frames_adjusted = 0;
  std::string covariance_method;      // "full", "block" or "none"
  std::vector<base::Reject> rejects;  // frames, points, observations, control points left out, with reasons
};

// Throws invalid_argument (options), failed_precondition where no two frames share enough points, and
// invalid_input where an observation names no frame, a frame no camera, or a number is not finite.
// Memory: about 400 bytes an observation. Cost: linear in observations times their number a point; the reduced system
// is dense up to 100 frames, sparse above. 50 frames, 209 000 observations: about 2 s.
[[nodiscard]] BundleResult adjust_bundle(const BundleProblem& problem, const BundleOptions& options,
                                         base::RunContext& ctx);

}  // namespace cairn::adjustment
