// A recorded survey in memory: what `io` reads from a survey folder.
#pragma once

#include <vector>

#include "survey/detection.hpp"
#include "survey/frame.hpp"
#include "survey/manifest.hpp"
#include "survey/tie_point.hpp"

namespace cairn::survey {

struct Survey {
  Manifest manifest;
  std::vector<Frame> frames;          // ascending id
  std::vector<Detection> detections;  // ascending id
  std::vector<TiePoint> ties;         // ascending id; empty where the source had none

  // nullptr where there is none. Cost: log n (records are sorted by id).
  [[nodiscard]] const Frame* frame(FrameId id) const;
  [[nodiscard]] const Camera* camera(CameraId id) const;
  [[nodiscard]] const Detection* detection(DetectionId id) const;
  [[nodiscard]] const Source* source(std::string_view kind) const;
};

}  // namespace cairn::survey
