// A basal contact: the line where a rock rests on its pedestal or on the ground.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/vec.hpp"

namespace cairn::survey {

struct ContactVertex {
  std::int64_t pad = 0;                              // separate contact patches of one rock
  std::int64_t order = 0;                            // along the patch's outline
  geometry::Vec3 position = geometry::Vec3::Zero();  // m, the frame of the rock's points or mesh
  bool observed = false;                             // the crease itself was seen; else it was inferred
  bool closed = true;                                // the patch's last vertex joins its first
  double sigma_m = 0.0;                              // standard deviation across the line, m, >= 0; 0 = not stated
};

// Sorted by pad and order. What is seen of a contact is its outer rim (the crease): what bears lies on or inside it.
using Contact = std::vector<ContactVertex>;

}  // namespace cairn::survey
