#include "ground/inflation.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/parallel.hpp"
#include "ground/distance.hpp"

namespace cairn::ground {
namespace {

constexpr std::size_t kBlock = 64;      // cells that the row pass takes at once
constexpr int kLongestFastReach = 180;  // 2 * 180^2 + 1 fits 16 bits
constexpr std::size_t kRowsPerStrip = 256;

// One row on: distance along the column to the last obstacle passed, saturated at far.
inline __attribute__((always_inline)) void column_step(const Occupancy* occupancy, const std::uint8_t* before,
                                                       std::uint8_t* out, std::size_t count, std::uint8_t far) {
  for (std::size_t c = 0; c < count; ++c) {
    const auto next = static_cast<std::uint8_t>(before[c] + 1);
    const std::uint8_t saturated = next < far ? next : far;
    out[c] = occupancy[c] == Occupancy::occupied ? std::uint8_t{0} : saturated;
  }
}

// Squares of the nearer of two column distances; returns whether any lies within reach.
inline __attribute__((always_inline)) bool square_block(const std::uint8_t* up, const std::uint8_t* down,
                                                        std::uint16_t* squares, std::size_t count,
                                                        std::uint16_t far_squared) {
  std::uint16_t least = far_squared;
  for (std::size_t c = 0; c < count; ++c) {
    const std::uint16_t g = up[c] < down[c] ? up[c] : down[c];
    const auto square = static_cast<std::uint16_t>(g * g);
    squares[c] = square < far_squared ? square : far_squared;
    least = squares[c] < least ? squares[c] : least;
  }
  return least < far_squared;
}

// Squared distance of 64 cells: least of squares[c + d] + d^2. Stops where every cell has one that no farther column
// can beat.
inline __attribute__((always_inline)) void row_block(const std::uint16_t* squares, int reach, std::uint16_t* best) {
  for (std::size_t i = 0; i < kBlock; ++i) best[i] = squares[i];
  for (int d = 1; d <= reach; ++d) {
    const std::uint16_t *left = squares - d, *right = squares + d;
    const auto d2 = static_cast<std::uint16_t>(d * d);
    for (std::size_t i = 0; i < kBlock; ++i) {
      const std::uint16_t nearer = left[i] < right[i] ? left[i] : right[i];
      const auto candidate = static_cast<std::uint16_t>(nearer + d2);
      best[i] = candidate < best[i] ? candidate : best[i];
    }
    if (d % 2 != 0) continue;
    std::uint16_t farthest = 0;
    for (std::size_t i = 0; i < kBlock; ++i) farthest = best[i] > farthest ? best[i] : farthest;
    if (farthest <= (d + 1) * (d + 1)) return;
  }
}

struct Kernel {
  void (*column)(const Occupancy*, const std::uint8_t*, std::uint8_t*, std::size_t, std::uint8_t);
  bool (*square)(const std::uint8_t*, const std::uint8_t*, std::uint16_t*, std::size_t, std::uint16_t);
  void (*row)(const std::uint16_t*, int, std::uint16_t*);
};

// The same integers on every processor; wider registers where there are any.
#if defined(__x86_64__)
__attribute__((target("avx2"))) void column_avx2(const Occupancy* o, const std::uint8_t* before, std::uint8_t* out,
                                                 std::size_t count, std::uint8_t far) {
  column_step(o, before, out, count, far);
}
__attribute__((target("avx2"))) bool square_avx2(const std::uint8_t* up, const std::uint8_t* down, std::uint16_t* out,
                                                 std::size_t count, std::uint16_t far_squared) {
  return square_block(up, down, out, count, far_squared);
}
__attribute__((target("avx2"))) void row_avx2(const std::uint16_t* squares, int reach, std::uint16_t* best) {
  row_block(squares, reach, best);
}
#endif
void column_plain(const Occupancy* o, const std::uint8_t* before, std::uint8_t* out, std::size_t count,
                  std::uint8_t far) {
  column_step(o, before, out, count, far);
}
bool square_plain(const std::uint8_t* up, const std::uint8_t* down, std::uint16_t* out, std::size_t count,
                  std::uint16_t far_squared) {
  return square_block(up, down, out, count, far_squared);
}
void row_plain(const std::uint16_t* squares, int reach, std::uint16_t* best) {
  row_block(squares, reach, best);
}

Kernel best_kernel() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) return {column_avx2, square_avx2, row_avx2};
#endif
  return {column_plain, square_plain, row_plain};
}

}  // namespace

Inflation::Inflation(const CostmapOptions& options) {
  CostmapOptions checked = options;
  base::validate(base::bind_options(checked), "costmap");
  reach_ = reach_cells(options);
  // One exponential per distinct distance, not per cell.
  table_.assign(static_cast<std::size_t>(reach_) * static_cast<std::size_t>(reach_) + 2, 0);
  for (std::size_t d2 = 0; d2 + 1 < table_.size(); ++d2)
    table_[d2] = cost_at(std::sqrt(static_cast<double>(d2)) * options.resolution_m, options);
}

void Inflation::run(const OccupancyGrid& occupancy, const CellRegion& region, std::uint8_t* out,
                    std::size_t stride) const {
  if (region.empty()) return;
  const bool fast = reach_ <= kLongestFastReach;
  const std::size_t rows =
      fast ? kRowsPerStrip : std::max<std::size_t>(kRowsPerStrip, static_cast<std::size_t>(reach_));
  base::parallel_for(region.rows, rows, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; r += rows) {
      const CellRegion strip{region.row + r, region.column, std::min(rows, end - r), region.columns};
      if (fast) run_strip(occupancy, strip, out + r * stride, stride);
      else run_general(occupancy, strip, out + r * stride, stride);
    }
  });
}

void Inflation::run_strip(const OccupancyGrid& occupancy, const CellRegion& strip, std::uint8_t* out,
                          std::size_t stride) const {
  static const Kernel kernel = best_kernel();
  const auto reach = static_cast<std::size_t>(reach_);
  const auto far = static_cast<std::uint8_t>(reach + 1);
  const auto far_squared = static_cast<std::uint16_t>(reach * reach + 1);
  const CellRegion seen = widened(strip, reach, occupancy.geometry);
  const std::size_t width = seen.columns, columns = occupancy.geometry.columns;
  const auto cells = [&](std::size_t row) { return &occupancy.values[row * columns + seen.column]; };

  // Distance to the nearest obstacle above, for each row of the strip.
  std::vector<std::uint8_t> up(strip.rows * width), from(width, far);
  for (std::size_t r = seen.row; r < strip.end_row(); ++r) {
    if (r < strip.row) {
      kernel.column(cells(r), from.data(), from.data(), width, far);
    } else {
      const std::uint8_t* before = r == strip.row ? from.data() : &up[(r - strip.row - 1) * width];
      kernel.column(cells(r), before, &up[(r - strip.row) * width], width, far);
    }
  }
  // Upwards again with the nearest below, and each row finished while it is at hand. Columns are padded so that every
  // block may look to both sides.
  const std::size_t offset = strip.column - seen.column, pad = reach;
  std::vector<std::uint16_t> squares(pad + width + reach + 2 * kBlock, far_squared);
  const std::size_t blocks = (width + kBlock - 1) / kBlock, around = (reach + kBlock - 1) / kBlock;
  std::vector<char> near(blocks);
  std::fill(from.begin(), from.end(), far);
  for (std::size_t r = seen.end_row(); r-- > strip.row;) {
    kernel.column(cells(r), from.data(), from.data(), width, far);
    if (r >= strip.end_row()) continue;
    const std::uint8_t* above = &up[(r - strip.row) * width];
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::size_t c = b * kBlock;
      near[b] = kernel.square(above + c, &from[c], &squares[pad + c], std::min(kBlock, width - c), far_squared) ? 1 : 0;
    }
    const Occupancy* here = &occupancy.values[r * columns + strip.column];
    std::uint8_t* row_out = out + (r - strip.row) * stride;
    for (std::size_t c = 0; c < strip.columns; c += kBlock) {
      const std::size_t count = std::min(kBlock, strip.columns - c);
      const std::size_t first = (offset + c) / kBlock, last = (offset + c + kBlock - 1) / kBlock;
      const std::size_t b0 = first > around ? first - around : 0, b1 = std::min(last + around + 1, blocks);
      const bool any =
          std::find(near.begin() + static_cast<std::ptrdiff_t>(b0), near.begin() + static_cast<std::ptrdiff_t>(b1),
                    1) != near.begin() + static_cast<std::ptrdiff_t>(b1);
      if (any) {
        std::uint16_t best[kBlock];
        kernel.row(&squares[pad + offset + c], reach_, best);
        for (std::size_t i = 0; i < count; ++i) row_out[c + i] = table_[best[i]];
      } else {
        std::memset(row_out + c, 0, count);
      }
      for (std::size_t i = 0; i < count; ++i)
        row_out[c + i] = here[c + i] == Occupancy::unknown ? kUnknown : row_out[c + i];
    }
  }
}

void Inflation::run_general(const OccupancyGrid& occupancy, const CellRegion& strip, std::uint8_t* out,
                            std::size_t stride) const {
  const CellRegion seen = widened(strip, static_cast<std::size_t>(reach_), occupancy.geometry);
  geometry::Grid<std::uint8_t> blocked({0.0, 0.0, 1.0, seen.columns, seen.rows}, 0);
  for (std::size_t r = 0; r < seen.rows; ++r)
    for (std::size_t c = 0; c < seen.columns; ++c)
      blocked.at(r, c) = occupancy.at(seen.row + r, seen.column + c) == Occupancy::occupied ? 1 : 0;
  const auto squared = squared_distance(blocked, reach_);
  for (std::size_t r = 0; r < strip.rows; ++r)
    for (std::size_t c = 0; c < strip.columns; ++c) {
      const auto d2 = squared.at(strip.row - seen.row + r, strip.column - seen.column + c);
      out[r * stride + c] = occupancy.at(strip.row + r, strip.column + c) == Occupancy::unknown
                                ? kUnknown
                                : table_[static_cast<std::size_t>(d2)];
    }
}

}  // namespace cairn::ground
