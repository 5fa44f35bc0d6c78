#include "ground/distance.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/parallel.hpp"

namespace cairn::ground {
namespace {

using geometry::Grid;

constexpr std::size_t kColumnsPerTask = 512;
constexpr std::size_t kRowsPerTask = 16;

// Distance along the column to the nearest obstacle, saturated at `far`. Columns are taken in blocks
// wide enough that each row of a block is a few cache lines.
Grid<std::uint16_t> column_distance(const Grid<std::uint8_t>& obstacle, std::uint16_t far) {
  const std::size_t rows = obstacle.geometry.rows, columns = obstacle.geometry.columns;
  Grid<std::uint16_t> distance(obstacle.geometry, far);
  base::parallel_for(columns, kColumnsPerTask, [&](std::size_t begin, std::size_t end) {
    const auto relax = [&](std::size_t row, const std::uint16_t* before) {
      const std::uint8_t* blocked = &obstacle.values[row * columns];
      std::uint16_t* out = &distance.values[row * columns];
      for (std::size_t c = begin; c < end; ++c) {
        const auto next = static_cast<std::uint16_t>(before == nullptr ? far : std::min<int>(before[c] + 1, far));
        out[c] = blocked[c] != 0 ? std::uint16_t{0} : std::min(out[c], next);
      }
    };
    for (std::size_t r = 0; r < rows; ++r) relax(r, r == 0 ? nullptr : &distance.values[(r - 1) * columns]);
    for (std::size_t r = rows; r-- > 0;) relax(r, r + 1 == rows ? nullptr : &distance.values[(r + 1) * columns]);
  });
  return distance;
}

// One parabola x -> (x - centre)^2 + height of the lower envelope, the lowest from `from` on.
struct Parabola {
  std::int64_t centre, height, from;
};

// First whole x at which the parabola of `right` lies strictly below that of `left` (centres ascending).
std::int64_t takes_over(const Parabola& left, std::int64_t centre, std::int64_t height) {
  const std::int64_t numerator = centre * centre - left.centre * left.centre + height - left.height;
  const std::int64_t denominator = 2 * (centre - left.centre);
  // floor division: the numerator may be negative
  std::int64_t quotient = numerator / denominator;
  if (numerator % denominator < 0) --quotient;
  return quotient + 1;
}

void row_pass(const std::uint16_t* column, std::int32_t* out, std::size_t columns, std::uint16_t far,
              std::int32_t far_squared, std::vector<Parabola>& envelope) {
  envelope.clear();
  for (std::size_t c = 0; c < columns; ++c) {
    if (column[c] >= far) continue;
    const auto centre = static_cast<std::int64_t>(c);
    const std::int64_t height = std::int64_t{column[c]} * column[c];
    std::int64_t from = 0;
    while (!envelope.empty()) {
      from = takes_over(envelope.back(), centre, height);
      if (from > envelope.back().from) break;
      envelope.pop_back();
      from = 0;
    }
    if (envelope.empty()) from = 0;
    if (from < static_cast<std::int64_t>(columns)) envelope.push_back({centre, height, from});
  }
  if (envelope.empty()) {
    std::fill(out, out + columns, far_squared);
    return;
  }
  std::size_t piece = 0;
  for (std::size_t c = 0; c < columns; ++c) {
    const auto x = static_cast<std::int64_t>(c);
    while (piece + 1 < envelope.size() && envelope[piece + 1].from <= x) ++piece;
    const std::int64_t d = x - envelope[piece].centre;
    out[c] = static_cast<std::int32_t>(std::min<std::int64_t>(d * d + envelope[piece].height, far_squared));
  }
}

}  // namespace

Grid<std::int32_t> squared_distance(const Grid<std::uint8_t>& obstacle, int reach) {
  constexpr int kLargestReach = 32000;  // its square fits 31 bits
  if (reach < 1 || reach > kLargestReach)
    throw base::Error(base::ErrorCode::invalid_argument, "reach of the distance field out of range")
        .found(std::to_string(reach) + " cells")
        .allowed("1 to 32000");
  const auto far = static_cast<std::uint16_t>(reach + 1);
  const std::int32_t far_squared = reach * reach + 1;
  Grid<std::int32_t> result(obstacle.geometry, far_squared);
  const Grid<std::uint16_t> column = column_distance(obstacle, far);
  const std::size_t columns = obstacle.geometry.columns;
  base::parallel_for(obstacle.geometry.rows, kRowsPerTask, [&](std::size_t begin, std::size_t end) {
    std::vector<Parabola> envelope;
    for (std::size_t r = begin; r < end; ++r)
      row_pass(&column.values[r * columns], &result.values[r * columns], columns, far, far_squared, envelope);
  });
  return result;
}

}  // namespace cairn::ground
