// A regular grid of nodes in space.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "geometry/vec.hpp"

namespace cairn::surface {

// Node (i, j, k) stands at origin + step * (i, j, k) [m]; counts >= 2; index runs fastest along x.
struct Lattice {
  geometry::Vec3 origin = geometry::Vec3::Zero();
  double step = 1.0;  // m, > 0
  std::array<std::int64_t, 3> count{2, 2, 2};

  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(count[0] * count[1] * count[2]); }
  [[nodiscard]] std::size_t index(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return static_cast<std::size_t>((k * count[1] + j) * count[0] + i);
  }
  [[nodiscard]] std::array<std::int64_t, 3> cell_of(std::size_t index) const {
    const auto n = static_cast<std::int64_t>(index);
    return {n % count[0], n / count[0] % count[1], n / (count[0] * count[1])};
  }
  [[nodiscard]] geometry::Vec3 node(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return origin + step * geometry::Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
  }
  [[nodiscard]] geometry::Vec3 node(std::size_t n) const {
    const auto c = cell_of(n);
    return node(c[0], c[1], c[2]);
  }
};

}  // namespace cairn::surface
