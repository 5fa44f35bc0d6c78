// Options of the bundle adjustment.
#pragma once

#include <cstdint>
#include <string>

#include "base/options.hpp"

namespace cairn::adjustment {

struct BundleOptions {
  // none | focal | distortion | radial | all (camera/projection_jacobian.hpp); auto = none, unless the stage knows
  // better
  std::string intrinsics = "auto";
  std::string loss = "huber";     // none | huber | cauchy, on the tie observations
  double loss_scale = 3.0;        // sigmas at which the loss leaves the square
  double sigma_px = 0.0;          // 1 sigma of a tie observation in u and in v; 0 = estimated from the residuals
  double control_sigma_px = 1.0;  // the same of a control point's observations
  double outlier_sigmas = 5.0;    // observations farther off than this are removed; 0 = none are
  std::int64_t max_rounds = 6;    // of: solve, estimate sigma_px, remove outliers
  std::int64_t max_iterations = 50;
  double function_tolerance = 1e-6;    // relative change of the cost at which a solve ends
  std::int64_t min_observations = 8;   // a frame with fewer keeps its pose
  double min_parallax_deg = 0.3;       // a point whose rays meet at less takes no part
  std::string triangulate = "better";  // better | always | never: points anew from the start poses
  bool priors = true;                  // the frames' sigmas hold their poses
  double prior_sigma_xy_m = 0.0;       // in place of every frame's sigma; 0 = as the frame says
  double prior_sigma_z_m = 0.0;
  double prior_sigma_rot_deg = 0.0;
  double prior_loss_scale = 3.0;              // Huber's, per frame [sigmas]: one wrong prior bends nothing; 0 = none
  std::string covariance = "auto";            // auto | full | block | none
  std::int64_t full_covariance_frames = 200;  // auto: up to this many frames with all correlations

  void visit(base::OptionVisitor& v) {
    v.choice("intrinsics", intrinsics, {"auto", "none", "focal", "distortion", "radial", "all"},
             "intrinsics that may change");
    v.choice("loss", loss, {"none", "huber", "cauchy"}, "loss of the tie observations");
    v.real("loss-scale", loss_scale, 0.1, 100.0, "sigmas at which the loss leaves the square");
    v.real("sigma-px", sigma_px, 0.0, 100.0, "1 sigma of a tie observation; 0 = estimated [px]");
    v.real("control-sigma-px", control_sigma_px, 0.01, 100.0, "1 sigma of a control point's observation [px]");
    v.real("outlier-sigmas", outlier_sigmas, 0.0, 1000.0, "tie observations farther off are removed; 0 = none");
    v.integer("max-rounds", max_rounds, 1, 100, "rounds of solving and removing outliers");
    v.integer("max-iterations", max_iterations, 1, 10000, "iterations of one solve");
    v.real("function-tolerance", function_tolerance, 1e-14, 1e-2, "relative change of the cost that ends a solve");
    v.integer("min-observations", min_observations, 4, 100000, "frames with fewer tie observations keep their pose");
    v.real("min-parallax-deg", min_parallax_deg, 0.0, 90.0, "points whose rays meet at less take no part [deg]");
    v.choice("triangulate", triangulate, {"better", "always", "never"}, "tie points anew from the start poses");
    v.flag("priors", priors, "the frames' sigmas hold their poses");
    v.real("prior-sigma-xy-m", prior_sigma_xy_m, 0.0, 1e6, "in place of every frame's sigma_xy_m; 0 = the frame's [m]");
    v.real("prior-sigma-z-m", prior_sigma_z_m, 0.0, 1e6, "in place of every frame's sigma_z_m; 0 = the frame's [m]");
    v.real("prior-sigma-rot-deg", prior_sigma_rot_deg, 0.0, 180.0,
           "in place of every frame's sigma_rot_deg; 0 = the frame's [deg]");
    v.real("prior-loss-scale", prior_loss_scale, 0.0, 1000.0, "Huber's scale of a frame's prior [sigmas]; 0 = none");
    v.choice("covariance", covariance, {"auto", "full", "block", "none"}, "a-posteriori sigmas of the poses");
    v.integer("full-covariance-frames", full_covariance_frames, 1, 100000,
              "with auto: up to this many frames with all correlations");
  }
};

}  // namespace cairn::adjustment
