// Matching where the poses already say where to look.
#pragma once

#include <vector>

#include "adjustment/image_features.hpp"
#include "geometry/rigid_transform.hpp"
#include "survey/camera.hpp"

namespace cairn::adjustment {

struct GuidedView {
  const survey::Camera* camera = nullptr;
  const ImageFeatures* features = nullptr;            // in pixels of the camera
  const std::vector<geometry::Vec2>* rays = nullptr;  // of the features, on the plane z = 1
  geometry::RigidTransform T_world_camera;
  double near_m = 0.0, far_m = 0.0;  // depths, along the optical axis, between which its points may lie, 0 < near < far
};

struct GuidedOptions {
  double tolerance = 0.01;        // half width of the strip searched [focal lengths of b]
  double ratio = 0.8;             // best / second-best descriptor distance within the strip
  double least_closeness = 0.92;  // product of the unit descriptors: a strip may hold no second candidate
};

// A feature of a can lie, by its depth, along a stretch of its epipolar line in b; only features of b within
// `tolerance` of the stretch are compared. Each feature of b is given to the nearest one of a. In the order of the
// features of a. Cost: about 20 comparisons a feature, where brute force makes thousands; so far weaker features can be
// used, and the ratio test is not spoilt by like-looking ground elsewhere.
[[nodiscard]] std::vector<FeaturePair> pair_features_guided(const GuidedView& a, const GuidedView& b,
                                                            const GuidedOptions& options = {});

}  // namespace cairn::adjustment
