// A box that an image tracker has given an identity.
#pragma once

#include <optional>
#include <string_view>

#include "survey/detection.hpp"
#include "survey/ids.hpp"

namespace cairn::survey {

// coasted: no detection in this frame, the box is the tracker's prediction. It is evidence of nothing: never a
// keyframe.
enum class TrackState { detected, coasted };

[[nodiscard]] std::string_view name_of(TrackState state);
[[nodiscard]] std::optional<TrackState> track_state_from(std::string_view name);

// One row of tracks.csv. `box.id` is the detection's own id; invalid where coasted.
struct TrackedBox {
  TrackId track;
  TrackState state = TrackState::detected;
  Detection box;

  friend bool operator==(const TrackedBox&, const TrackedBox&) = default;
};

}  // namespace cairn::survey
