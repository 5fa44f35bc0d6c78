// Points by square cells seen from above.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/vec.hpp"

namespace cairn::segmentation {

// Immutable; queries may run from several threads. Build linear; 4 bytes a point and at most 4 M cells.
// Points that are not finite are left out.
class PlanIndex {
 public:
  // The points (m) must outlive the index and number below 2^32.
  explicit PlanIndex(std::span<const geometry::Vec3> points, double cell = 1.0);

  // Indices, ascending, of the points within `radius` [m] of `centre` in plan.
  [[nodiscard]] std::vector<std::size_t> within(const geometry::Vec2& centre, double radius) const;

 private:
  std::span<const geometry::Vec3> points_;
  geometry::Vec2 corner_ = geometry::Vec2::Zero();
  double cell_ = 1.0;
  std::size_t columns_ = 0, rows_ = 0;
  std::vector<std::uint32_t> starts_;   // first entry of each cell, and one past the last
  std::vector<std::uint32_t> entries_;  // point indices, cell by cell
};

}  // namespace cairn::segmentation
