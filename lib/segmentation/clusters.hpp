// Groups of points that hang together.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "geometry/vec.hpp"

namespace cairn::segmentation {

// Connected groups under "nearer than tolerance" (single linkage; Euclidean cluster extraction, Rusu 2009),
// ascending indices in each, largest group first (ties: lower first index).
// points: finite, m; tolerance > 0 m. Positions are held in single precision about their mean.
// Cost about n log n.
[[nodiscard]] std::vector<std::vector<std::size_t>> euclidean_clusters(std::span<const geometry::Vec3> points,
                                                                       double tolerance);

}  // namespace cairn::segmentation
