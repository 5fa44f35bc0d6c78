// What the joint fit knows of one target: its boxes, where it starts, what came out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "geometry/primitives.hpp"
#include "localisation/body_fit.hpp"
#include "localisation/body_solver.hpp"
#include "survey/survey.hpp"

namespace cairn::localisation {

// A box as the fit takes it.
struct SeenBox {
  std::int64_t time_ns = 0;
  survey::FrameId frame;
  BoxPlanes planes;
  double side_variance = 1.0;                    // px^2, assumed
  double turn_m = 0.0;                           // what the rotation's sigma is at the target
  geometry::Mat2 pose = geometry::Mat2::Zero();  // of the box's place by the pose, px^2, assumed
  double depth_m = 0.0;                          // of the target
  double reach_m = 0.0;                          // half the box's mean side at the target's depth
  bool whole = true;
};

// One target on its way through the fit.
struct BodyWork {
  std::size_t target = 0;  // index
  std::vector<SeenBox> boxes;
  Body start;
  BodySolution solution;
  std::string reason;
};

// The boxes of a target (in time, at most max_boxes) and where the fit starts; reason fit_too_few_boxes or
// fit_one_direction where it cannot.
[[nodiscard]] BodyWork prepare_body(const survey::Target& target, std::size_t index, const survey::Survey& survey,
                                    const BodyFitOptions& options);

// The smallest upright cylinder around a body, relative to its origin.
[[nodiscard]] geometry::VerticalCylinder cylinder_of(const Body& body);

struct CentreCovariance {
  geometry::Mat3 value = geometry::Mat3::Zero();  // m^2, of the cylinder's centre; 0 where there is no fit
  // Of the standard deviations by stretches of a video over those of independent boxes; empty where there are too few
  // stretches (photos, short recordings).
  std::optional<double> slow;
};

// The parameters' covariance through the cylinder. Boxes near one another in time err together - by the pose's slow
// errors, by the same side of the object being seen - so each stretch of a video counts as one observation (block
// sandwich: Liang & Zeger 1986, Biometrika 73:13).
[[nodiscard]] CentreCovariance centre_covariance(const BodyWork& work);

// Share of the rotations' sigma that all frames of an object have in common. Where rotations err slowly, some of their
// error never changes; that shows in no residual, only the slow part does. The option's value where nothing is known.
[[nodiscard]] double common_turn(const std::vector<CentreCovariance>& covariances, const BodyFitOptions& options);

}  // namespace cairn::localisation
