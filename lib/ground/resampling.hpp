// Occupancy on another grid, never losing an obstacle.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "ground/occupancy.hpp"

namespace cairn::ground {

// A cell of `to` takes what the cells of `from` say whose inside it overlaps: occupied where any is, else unknown where
// any is or where it reaches beyond `from`, else free. Overlaps thinner than a millionth of a cell do not count. On a
// finer grid of the same corner this is the value of the cell around it. Cost: overlaps of cells.
class Resampling {
 public:
  Resampling(const geometry::GridGeometry& from, const geometry::GridGeometry& to);

  // Whether both grids have the same cells, but for whole cells at the borders.
  [[nodiscard]] bool aligned() const { return aligned_; }
  // Rows [begin, end) of `from` that rows [first, first + rows) of `to` overlap; may be none.
  [[nodiscard]] std::pair<std::size_t, std::size_t> rows_needed(std::size_t first, std::size_t rows) const;
  // Rows of `to` from `first` on into `strip`, as many as it has. `window` holds at least the rows needed of `from`,
  // from window_first on.
  void rows(const OccupancyGrid& window, std::size_t window_first, std::size_t first, OccupancyGrid& strip) const;

 private:
  // Cells of one axis of `from`; `outside` where the cell of `to` reaches beyond.
  struct Overlap {
    std::size_t begin = 0, end = 0;
    bool outside = false;
  };
  static Overlap overlap(double begin, double end, std::size_t count);
  [[nodiscard]] Overlap row(std::size_t row) const;

  geometry::GridGeometry from_, to_;
  double ratio_ = 1.0;
  bool aligned_ = false;
  std::vector<Overlap> columns_;
};

// The whole grid at once.
[[nodiscard]] OccupancyGrid resampled(const OccupancyGrid& from, const geometry::GridGeometry& to);

// A grid that was turned counter-clockwise by yaw [rad] about its lower left corner (the origin of a ROS map), on a
// grid that was not; the same rule.
[[nodiscard]] OccupancyGrid resampled_turned(const OccupancyGrid& from, double yaw, const geometry::GridGeometry& to);
// Smallest grid of cells of `cell` metres, aligned to multiples of it, that holds the turned grid.
[[nodiscard]] geometry::GridGeometry grid_around_turned(const geometry::GridGeometry& from, double yaw, double cell);

}  // namespace cairn::ground
