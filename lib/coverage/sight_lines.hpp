// Metrics over the sight lines of one facet.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "geometry/vec.hpp"

namespace cairn::coverage {

// Unit vectors from a facet to the cameras that see it, by component.
struct SightLines {
  std::vector<float> x, y, z;

  void clear() {
    x.clear();
    y.clear();
    z.clear();
  }
  void add(const geometry::Vec3& direction) {
    x.push_back(static_cast<float>(direction.x()));
    y.push_back(static_cast<float>(direction.y()));
    z.push_back(static_cast<float>(direction.z()));
  }
  [[nodiscard]] std::size_t size() const { return x.size(); }
};

// Of all pairs of n >= 2 unit vectors, given by component, the largest angle [rad] and that of the next pair (NaN where
// n is 2); errors below 1e-6 rad. The two pairs may share a vector.
// `scratch` is for the function's own use. Cost about n; n^2 where every pair competes.
struct WidestAngles {
  double first = 0.0, second = 0.0;
};
[[nodiscard]] WidestAngles widest_angles(std::span<const float> x, std::span<const float> y, std::span<const float> z,
                                         SightLines& scratch);

}  // namespace cairn::coverage
