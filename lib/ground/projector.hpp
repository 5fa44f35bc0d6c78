// Paper B's object projector: a box of one image to a position and a size on the ground.
#pragma once

#include <string>
#include <variant>

#include "base/options.hpp"
#include "base/reject.hpp"
#include "geometry/primitives.hpp"
#include "geometry/vec.hpp"
#include "ground/class_table.hpp"
#include "ground/ground_height.hpp"
#include "survey/camera.hpp"
#include "survey/frame.hpp"

namespace cairn::ground {

struct ProjectionOptions {
  std::string mode = "robust";  // paper: (B.1)-(B.3) on a level plane; robust: an upright body on the terrain
  double ground_up_m = 0.0;     // local up of the plane Z = 0 of paper B, and where no terrain is known
  // Lines of sight that are let through.
  double min_depression_deg = 5.0;  // robust: a flatter ray says too little about the distance
  double max_range_m = 500.0;       // longest line of sight (in paper mode too: it bounds k near the horizon)
  double ray_step_m = 0.25;         // least step of the march over the terrain: ridges thinner than it are missed
  double footprint_gsd_m = 0.04;    // ground that is sampled more coarsely, per pixel, is not in a packet's footprint:
                                    //   an object is not expected to be detected there (12 px for half a metre)
  double edge_margin_px = 3.0;      // robust: an edge of a box nearer to the image border says nothing of the object
  // Noise, 1 sigma.
  double box_noise_px = 2.0;         // of each edge of a box
  double box_noise_fraction = 0.02;  // the same as a fraction of the box's side, added in squares
  double pose_noise_xy_m = 0.05;     // of the camera, each axis, where the frame says nothing (RTK with lever arm)
  double pose_noise_z_m = 0.08;
  double pose_noise_rot_deg = 0.3;
  double terrain_noise_m = 0.05;    // height of the terrain below the object
  double plane_noise_m = 0.3;       // height of the plane there ("flat within about 1 m")
  double shape_noise = 0.05;        // of the position, level, as a fraction of the width: a body is not its model
  double slope_base_m = 1.0;        // length over which the terrain's slope under an object is taken
  double max_sigma_position_m = 5;  // robust: results that are less certain are rejected

  void visit(base::OptionVisitor& visitor);
};

struct Projected {
  geometry::Vec3 position = geometry::Vec3::Zero();    // foot (paper: the ground behind the box's centre), local ENU, m
  geometry::Mat2 covariance = geometry::Mat2::Zero();  // of east and north, m^2
  double width_m = 0.0, sigma_width_m = 0.0;           // diameter of the upright body; paper: B7
  double height_m = 0.0, sigma_height_m = 0.0;         // paper: 0, 0 (not known)
  bool vehicle = false;
  bool on_terrain = false;  // false: the plane stood in for the terrain
};

// Reasons: bad_box (not finite, or max <= min), bad_pose, above_horizon, too_far, cut_by_border, no_fit, uncertain.
using Projection = std::variant<Projected, base::Reject>;

// paper: position = (B.1) with the box's centre as p, width = B7, on the plane at ground_up_m; lens distortion is taken
// off the pixels first. k <= 0 is above_horizon. Heights are ignored: an object of which the centre is h above the
// plane comes out r h / (H - h) too far and H / (H - h) too wide (r = its true range from below the camera, H = the
// camera's height). The covariance is that of (B.1) under the noise of box, pose and plane.
//
// robust: the upright body of `model` that fills the box, with its foot on the terrain: east, north, width and height
// minimise the four edges' residuals over their noise plus the model's prior of the height (Levenberg-Marquardt; the
// terrain under the object is a plane that is taken anew with each solution). Covariance: of that fit, and of pose and
// terrain noise through it; errors of the pose are common to all boxes of a frame. A box that touches the image border
// is fitted by its other edges; with two or more edges cut it is rejected.
// box: raw image, corner convention, px. Result: local ENU. `record` names the box in rejects.
// Deterministic; about 0.1 ms, and max_range / ray_step evaluations of the terrain.
[[nodiscard]] Projection project_box(const geometry::PixelBox& box, const survey::Frame& frame,
                                     const survey::Camera& camera, const GroundHeight& ground,
                                     const ProjectionOptions& options, const ObjectModel& model = {},
                                     const std::string& record = "box");

}  // namespace cairn::ground
