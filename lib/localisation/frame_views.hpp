// The frames of a survey made ready: ideal cameras in the order of the recording.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "base/reject.hpp"
#include "localisation/options.hpp"
#include "localisation/view.hpp"
#include "survey/survey.hpp"

namespace cairn::localisation {

// A frame with its ideal camera and how well its pose is known.
struct FrameView {
  survey::FrameId id;
  std::int64_t time_ns = 0;
  const survey::Camera* camera = nullptr;
  View view;
  double sigma_xy_m = 0.0, sigma_z_m = 0.0, sigma_rot_rad = 0.0;
  std::vector<std::size_t> boxes;      // whole boxes: indices into PreparedBoxes::boxes
  std::vector<std::size_t> cut_boxes;  // boxes cut by the image border (robust only)
};

struct FrameViews {
  std::vector<FrameView> frames;                    // in the order of the recording
  std::map<survey::FrameId, std::size_t> index;     // into frames
  std::map<survey::FrameId, std::string> unusable;  // with the reason
  std::size_t clock_jumps = 0;                      // places where the clock ran backwards; 0 where times were sorted
};

// The order is that of time, then id. A clock that was set back would shuffle two parts of a flight into one another:
// where, in the order of ids, the time falls at few places (at most one in kFramesPerJump frames), these are clock
// jumps, the order of ids is kept and each is reported (`clock_jump`, the frame is used). More falls mean unsorted
// frames: time decides.
// Rejects: unknown_camera, bad_pose, clock_jump. The survey must outlive the views.
[[nodiscard]] FrameViews frame_views(const survey::Survey& survey, const LocateOptions& options,
                                     std::vector<base::Reject>& rejects);

}  // namespace cairn::localisation
