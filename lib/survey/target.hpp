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

// A stage that a target entered, and when. Its boxes so far are those of frames up to and including `frame`.
struct StageEntry {
  TargetState state = TargetState::generated;
  FrameId frame;

  friend bool operator==(const StageEntry&, const StageEntry&) = default;
};

// The body fitted to all boxes of a target at once, after the filter.
struct RefinedBody {
  geometry::Vec3 centre = geometry::Vec3::Zero();       // of the cylinder below, local ENU, m
  geometry::Mat3 covariance = geometry::Mat3::Zero();   // of that centre: box and pose errors propagated, m^2
  geometry::VerticalCylinder cylinder;                  // bounds the body
  geometry::Vec3 semi_axes_m = geometry::Vec3::Zero();  // of the ellipsoid: east', north', up' in its own axes
  double azimuth_deg = 0.0;                             // of the first semi-axis, clockwise from north, 0..180
  double rms_px = 0.0;                                  // of the box sides that were kept
  std::size_t boxes = 0;                                // boxes kept
  std::size_t rejected_boxes = 0;                       // down-weighted to less than half by the robust loss
};

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
  std::vector<StageEntry> history;                      // stages entered, in order of time
  std::optional<RefinedBody> refined;                   // empty where it was not fitted; `reasons` says why
};

}  // namespace cairn::survey
