// A located object: what the 3-D points filter makes of many detections.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/primitives.hpp"
#include "geometry/vec.hpp"
#include "survey/ids.hpp"

namespace cairn::survey {

// Paper A, A18. `deregistered` targets are kept, with the reason.
enum class TargetState { generated, converging, converged, mapped, deregistered };

[[nodiscard]] std::string_view name_of(TargetState state);
[[nodiscard]] std::optional<TargetState> target_state_from(std::string_view name);

struct Target {
  TargetId id;
  std::string object_class;
  TargetState state = TargetState::generated;
  geometry::Vec3 centre = geometry::Vec3::Zero();       // local ENU, m
  geometry::Mat3 covariance = geometry::Mat3::Zero();   // of the centre (not the spread of the points), m^2
  std::vector<DetectionId> detections;                  // associated boxes, ascending
  std::vector<FrameId> keyframes;                       // frames that updated the points
  std::optional<geometry::VerticalCylinder> bcylinder;  // bounding cylinder, paper A A23
  std::vector<double> entropy_nats;                     // after each keyframe, (A.4)
  std::vector<double> divergence;                       // after each keyframe, (A.5); one shorter than entropy
  std::vector<std::string> reasons;                     // reason codes: why it ended in its state
  double mean_score = 0.0;                              // of its detections, 0..1
};

}  // namespace cairn::survey
