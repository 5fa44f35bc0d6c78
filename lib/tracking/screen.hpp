// Boxes a tracker cannot use, told apart before it sees them.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "geometry/primitives.hpp"

namespace cairn::tracking {

// One detector's box of one image.
struct BoxObservation {
  geometry::PixelBox box;  // px
  int object_class = 0;    // any numbering; compared only
  double score = 1.0;      // any scale
};

enum class BoxFault { none, non_finite_box, negative_size_box, zero_area_box, duplicate_box, low_score };
// The reason code of a fault: its own name.
[[nodiscard]] const char* name_of(BoxFault fault);
// One sentence for people.
[[nodiscard]] std::string describe(BoxFault fault, const BoxObservation& observation);

// The fault of each box of one frame. A duplicate is a box equal in class and in all four sides to one before it
// (score not compared); it is `none` where keep_duplicates. Cost: n log n.
[[nodiscard]] std::vector<BoxFault> screen_boxes(std::span<const BoxObservation> boxes, double min_score,
                                                 bool keep_duplicates);

}  // namespace cairn::tracking
