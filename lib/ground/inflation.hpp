// The inner loop of a costmap: exact distance, saturated where it no longer matters, to cost.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ground/costmap.hpp"
#include "ground/occupancy.hpp"

namespace cairn::ground {

// Rows and columns are passed one after the other, as in squared_distance(), but a strip of rows at a time, in integers
// of 8 and 16 bits, and with the row pass as a search outwards from the cell that ends where no nearer obstacle can
// come: sixty-four cells at once, d steps for a distance of d cells. Where the reach is more than 180 cells the general
// distance takes over, strip by strip.
class Inflation {
 public:
  // Throws invalid_argument for options out of range.
  explicit Inflation(const CostmapOptions& options);

  [[nodiscard]] int reach() const { return reach_; }

  // Cost of the cells of `region` to out, whose first value is the region's north-western cell and whose rows lie
  // `stride` values apart. Parallel by strips; the bytes do not depend on strips nor threads.
  void run(const OccupancyGrid& occupancy, const CellRegion& region, std::uint8_t* out, std::size_t stride) const;

 private:
  void run_strip(const OccupancyGrid& occupancy, const CellRegion& strip, std::uint8_t* out, std::size_t stride) const;
  void run_general(const OccupancyGrid& occupancy, const CellRegion& strip, std::uint8_t* out,
                   std::size_t stride) const;

  int reach_ = 1;
  std::vector<std::uint8_t> table_;  // cost by squared distance in cells, up to reach^2 + 1
};

}  // namespace cairn::ground
