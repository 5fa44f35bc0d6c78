// The level plane on which the matches of two images agree best.
#pragma once

#include <span>

#include "adjustment/feature_matches.hpp"
#include "geometry/rigid_transform.hpp"
#include "survey/camera.hpp"

namespace cairn::adjustment {

struct GroundView {
  const survey::Camera* camera = nullptr;
  geometry::RigidTransform T_world_camera;
};

struct GroundPlaneFit {
  double median_m = 0.0;    // median distance of the two ground points of a match; infinite where there is no plane
  double plane_up_m = 0.0;  // local up
  double turn_deg = 0.0;    // least-squares rotation from the ground points of a to those of b
};

// Cameras min_height..max_height [m] above the plane. Infinite where most rays do not point down.
[[nodiscard]] GroundPlaneFit fit_ground_plane(const GroundView& a, const GroundView& b,
                                              std::span<const PixelMatch> matches, double min_height,
                                              double max_height);

}  // namespace cairn::adjustment
