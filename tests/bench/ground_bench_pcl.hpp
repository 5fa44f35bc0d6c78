// The peer of the ground filter: PCL's approximate progressive morphological filter.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/vec.hpp"

namespace cairn::bench {

struct PclGroundOptions {
  float cell = 1.0F, slope = 0.7F, initial_distance = 0.5F, max_distance = 3.0F, base = 2.0F;
  int max_window = 20;
  bool exponential = true;
};

// 1 where a point is no ground. Points are handed over in single precision about their first.
[[nodiscard]] std::vector<std::uint8_t> pcl_objects(std::span<const geometry::Vec3> points,
                                                    const PclGroundOptions& options);

}  // namespace cairn::bench
