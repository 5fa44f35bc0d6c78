// Shortest paths on a map whose free cells all cost the same: jump point search.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "base/run_context.hpp"
#include "geometry/grid.hpp"

namespace cairn::ground {

// Free and blocked cells as bits, by rows and by columns, so that a scan along either looks at 64 cells at once.
// A border of blocked cells surrounds the map. 2 bits a cell.
class BlockedBits {
 public:
  // blocked: non-zero where a cell is blocked, 256 entries, by the cell's cost.
  BlockedBits(const geometry::Grid<std::uint8_t>& cost, const std::vector<std::uint8_t>& blocked);

  // Lines of bits: line 0 and the last are the border; bit 0 of a line and all bits beyond its length are blocked.
  struct Lines {
    std::size_t words = 0;  // a line
    std::vector<std::uint64_t> bits;
    [[nodiscard]] const std::uint64_t* line(std::int64_t i) const { return &bits[static_cast<std::size_t>(i) * words]; }
  };
  // Coordinates count from 1 within the border: cell (row, column) is bit column + 1 of rows.line(row + 1), and
  // bit row + 1 of columns.line(column + 1).
  Lines rows, columns;

  [[nodiscard]] bool blocked(std::int64_t row, std::int64_t column) const {
    return (rows.line(row)[column >> 6] >> (column & 63) & 1) != 0;
  }
};

struct JumpPath {
  // Turning points from the start to the goal, row and column. Between two of them lie diagonal or straight steps of
  // one direction. Empty = there is no path.
  std::vector<std::pair<std::int64_t, std::int64_t>> corners;
  std::int64_t straight = 0, diagonal = 0;  // steps of either kind
  std::uint64_t expansions = 0;
};

// A shortest 8-connected path that cuts no corners. Jump point search (Harabor & Grastien 2011; the rule for uncut
// corners, block-wise scans and pruned intermediate points: 2012, 2014). Start and goal are free cells, row and column
// from 0. Lengths are kept as whole numbers of straight and diagonal steps, so nothing is lost by summing.
// Cost: n log n in the corners of obstacles met, plus the scans between.
[[nodiscard]] JumpPath jump_path(const BlockedBits& map, std::pair<std::int64_t, std::int64_t> start,
                                 std::pair<std::int64_t, std::int64_t> goal, base::RunContext& ctx);

}  // namespace cairn::ground
