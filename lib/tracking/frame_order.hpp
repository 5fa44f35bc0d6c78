// The order in which a tracker takes a survey's frames, and the time between them.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/reject.hpp"
#include "survey/frame.hpp"

namespace cairn::tracking {

struct FrameOrderOptions {
  bool real_time = false;    // dt from the time stamps; false: every step is 1
  double clock_jump = 50.0;  // a step of more nominal periods than this is a jump of the clock, > 1
};

struct FrameStep {
  std::size_t frame = 0;  // index into the frames given
  double dt = 1.0;        // since the step before, in nominal periods, > 0
  bool starts = false;    // no track reaches across: another camera, or the clock jumped
};

struct FrameOrder {
  std::vector<FrameStep> steps;       // camera by camera, ascending camera id
  std::vector<base::Reject> notices;  // what was found odd; nothing was left out for it
};

// frames: ascending id. Where no frame has a time stamp, the order is that of the ids. Else it is that of the time
// stamps within each stretch between clock jumps: a step backwards by more than `clock_jump` periods (as a clock that
// was set anew makes; where more than one in twenty steps is such, the ids are in no order and all are sorted by time),
// or forwards. The nominal period is the median of the positive steps.
// Notices: unsorted_frames (times not ascending with the ids), clock_jump, duplicate_time (dt = 1/1000).
// Cost n log n.
[[nodiscard]] FrameOrder order_frames(std::span<const survey::Frame> frames, const FrameOrderOptions& options);

}  // namespace cairn::tracking
