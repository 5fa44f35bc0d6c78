// A detector's box in one image.
#pragma once

#include <string>

#include "geometry/primitives.hpp"
#include "survey/ids.hpp"

namespace cairn::survey {

struct Detection {
  DetectionId id;
  FrameId frame;
  std::string object_class;  // "boulder"; free text, compared exactly
  double score = 1.0;        // 0..1
  geometry::PixelBox box;    // raw image, corner convention, px

  friend bool operator==(const Detection&, const Detection&) = default;
};

}  // namespace cairn::survey
