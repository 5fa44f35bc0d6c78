// Located objects to obstacles of a ground vehicle.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "base/options.hpp"
#include "base/reject.hpp"
#include "base/run_context.hpp"
#include "ground/class_table.hpp"
#include "ground/ground_height.hpp"
#include "survey/obstacle.hpp"
#include "survey/survey.hpp"
#include "survey/target.hpp"

namespace cairn::ground {

struct ObstacleOptions {
  ClassTable classes;
  std::string least_state = "converging";  // targets of a lower state are left out (converging: two consistent boxes)
  double edge_margin_px = 5.0;             // boxes nearer to the image border do not show the whole width
  double min_height_m = 0.1;               // height given to an object that the ground model does not let stand out

  void visit(base::OptionVisitor& visitor);
};

struct ObstacleResult {
  std::vector<survey::Obstacle> obstacles;   // in the order of the targets
  std::vector<base::Reject> rejects;         // target_deregistered, not_located, no_size
  std::vector<std::string> unknown_classes;  // taken as obstacles, each with a warning
  std::size_t without_ground = 0;            // foot taken from the object's own height
};

// Position: the point of the ground below the target's centre. Covariance: the centre's, east and north.
// Width and height: an upright cylinder of diameter D and height H about the centre spans, along an image axis, the
// pixels D |j_h| + H |j_z|, with j the derivative of that pixel coordinate by the position (B7 made true for any view).
// H is twice the centre's height above the ground (the centre of an outline lies half way up), at least min-height-m;
// where no ground is known, H = D/2. D of a box is the larger of its two axes' values, as it must hold the object;
// the width is the median over the boxes that are whole. Without such boxes: the bounding cylinder's.
// First and last seen: capture times of its boxes' frames. Misses: later frames that show its place within the middle
// 96 % of the image, no farther than twice the farthest of its own boxes' frames, and not it.
// Linear in detections and in targets times frames; log n to find each.
[[nodiscard]] ObstacleResult make_obstacles(std::span<const survey::Target> targets, const survey::Survey& survey,
                                            const GroundHeight& ground, const ObstacleOptions& options,
                                            base::RunContext& ctx);

}  // namespace cairn::ground
