// How much two boxes of one image have in common.
#pragma once

#include "geometry/primitives.hpp"

namespace cairn::evaluation {

// Area of the intersection, px^2; 0 where they only touch.
[[nodiscard]] double intersection(const geometry::PixelBox& a, const geometry::PixelBox& b);
// Intersection over union, 0..1; 0 where both are empty. Sides are real numbers (no inclusive pixels).
[[nodiscard]] double iou(const geometry::PixelBox& a, const geometry::PixelBox& b);

}  // namespace cairn::evaluation
