// Which box continues which track.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "geometry/primitives.hpp"

namespace cairn::tracking {

inline constexpr std::size_t kNoMatch = static_cast<std::size_t>(-1);

// Intersection over union, 0 to 1; 0 where they are apart. Areas must be positive.
[[nodiscard]] double intersection_over_union(const geometry::PixelBox& a, const geometry::PixelBox& b);

// A box with its class; boxes of different classes never match. Give all the same class where it does not count.
struct ClassedBox {
  geometry::PixelBox box;
  int object_class = 0;
};

// SORT's association. Where every row and column of (IoU > least) holds at most one pair, those pairs; else the
// assignment of the greatest summed IoU over all pairs, from which pairs with IoU < least are dropped. So a pair of
// IoU = least is taken in the second case only, as in the reference.
//
// The assignment is solved for each connected group of boxes and tracks with IoU > 0: pairs outside add nothing to the
// sum and are dropped anyway. Result: for each detection the index of its track, or kNoMatch.
// Cost: detections x tracks, plus the cube of the largest group.
[[nodiscard]] std::vector<std::size_t> match_boxes(std::span<const ClassedBox> detections,
                                                   std::span<const ClassedBox> tracks, double least_iou);

}  // namespace cairn::tracking
