// Of boxes that show one object, the best.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "geometry/primitives.hpp"

namespace cairn::detection {

struct ScoredBox {
  geometry::PixelBox box;
  std::size_t object_class = 0;
  double score = 0.0;  // 0..1

  friend bool operator==(const ScoredBox&, const ScoredBox&) = default;
};

[[nodiscard]] double intersection_over_union(const geometry::PixelBox& a, const geometry::PixelBox& b);
// Shared area over the area of `part`.
[[nodiscard]] double share_inside(const geometry::PixelBox& part, const geometry::PixelBox& whole);

// Non-maximum suppression within each class: in order of falling score (ties: order given), a box stays where its IoU
// with every one that stays is at most `iou`. Result in that order.
[[nodiscard]] std::vector<ScoredBox> suppress(std::span<const ScoredBox> boxes, double iou);

}  // namespace cairn::detection
