#include "segmentation/grid_fill.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "base/parallel.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Grid;

constexpr std::size_t kRows = 32;  // a piece of parallel work

// One level of the pyramid: sums of known values and how many.
struct Level {
  std::size_t rows = 0, columns = 0;
  std::vector<float> value;
  std::vector<std::uint8_t> known;
};

Level coarser(const Level& fine) {
  Level level;
  level.rows = (fine.rows + 1) / 2;
  level.columns = (fine.columns + 1) / 2;
  level.value.assign(level.rows * level.columns, 0.0F);
  level.known.assign(level.value.size(), 0);
  base::parallel_for(level.rows, kRows, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r)
      for (std::size_t c = 0; c < level.columns; ++c) {
        float sum = 0.0F;
        int count = 0;
        for (std::size_t i = 2 * r; i < std::min(2 * r + 2, fine.rows); ++i)
          for (std::size_t j = 2 * c; j < std::min(2 * c + 2, fine.columns); ++j)
            if (fine.known[i * fine.columns + j] != 0) {
              sum += fine.value[i * fine.columns + j];
              ++count;
            }
        if (count == 0) continue;
        level.value[r * level.columns + c] = sum / static_cast<float>(count);
        level.known[r * level.columns + c] = 1;
      }
  });
  return level;
}

// Bilinear value of a complete coarse level at a fine cell's centre.
float sample(const Level& coarse, std::size_t row, std::size_t column) {
  const auto place = [](std::size_t i, std::size_t count) {
    const float x = std::max(0.0F, (static_cast<float>(i) + 0.5F) * 0.5F - 0.5F);
    const std::size_t lo = std::min(static_cast<std::size_t>(x), count - 1);
    return std::pair(lo, x - static_cast<float>(lo));
  };
  const auto [r, a] = place(row, coarse.rows);
  const auto [c, b] = place(column, coarse.columns);
  const std::size_t r1 = std::min(r + 1, coarse.rows - 1), c1 = std::min(c + 1, coarse.columns - 1);
  const auto at = [&coarse](std::size_t i, std::size_t j) { return coarse.value[i * coarse.columns + j]; };
  return (1.0F - a) * ((1.0F - b) * at(r, c) + b * at(r, c1)) + a * ((1.0F - b) * at(r1, c) + b * at(r1, c1));
}

void relax(Grid<float>& grid, const std::vector<std::size_t>& filled, int rounds) {
  const std::size_t columns = grid.geometry.columns, rows = grid.geometry.rows;
  for (int round = 0; round < rounds; ++round)
    for (const std::size_t k : filled) {
      const std::size_t r = k / columns, c = k % columns;
      float sum = 0.0F;
      int count = 0;
      const auto take = [&](bool there, std::size_t i) {
        if (!there) return;
        sum += grid.values[i];
        ++count;
      };
      take(r > 0, k - columns);
      take(r + 1 < rows, k + columns);
      take(c > 0, k - 1);
      take(c + 1 < columns, k + 1);
      if (count > 0) grid.values[k] = sum / static_cast<float>(count);
    }
}

// Running extreme over a window of 2 radius + 1 of one line, ends included as far as they go.
// scratch holds two lines of n.
template <typename T, typename Better>
void line_extreme(const T* in, T* out, std::size_t n, std::size_t step, std::size_t radius, Better better, T worst,
                  std::vector<T>& scratch) {
  const std::size_t window = 2 * radius + 1;
  const std::size_t padded = n + 2 * radius;
  scratch.resize(2 * padded);
  T *forward = scratch.data(), *backward = scratch.data() + padded;
  const auto value = [&](std::size_t i) { return i < radius || i >= radius + n ? worst : in[(i - radius) * step]; };
  for (std::size_t i = 0; i < padded; ++i) forward[i] = i % window == 0 ? value(i) : better(forward[i - 1], value(i));
  for (std::size_t i = padded; i-- > 0;)
    backward[i] = i % window == window - 1 || i + 1 == padded ? value(i) : better(backward[i + 1], value(i));
  for (std::size_t i = 0; i < n; ++i) out[i * step] = better(backward[i], forward[i + window - 1]);
}

template <typename T, typename Better>
void square_extreme(std::vector<T>& values, std::size_t rows, std::size_t columns, std::size_t radius, Better better,
                    T worst) {
  base::parallel_for(rows, kRows, [&](std::size_t begin, std::size_t end) {
    std::vector<T> scratch, line(columns);
    for (std::size_t r = begin; r < end; ++r) {
      std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(r * columns), columns, line.begin());
      line_extreme(line.data(), values.data() + r * columns, columns, 1, radius, better, worst, scratch);
    }
  });
  base::parallel_for(columns, kRows, [&](std::size_t begin, std::size_t end) {
    std::vector<T> scratch, line(rows), result(rows);
    for (std::size_t c = begin; c < end; ++c) {
      for (std::size_t r = 0; r < rows; ++r) line[r] = values[r * columns + c];
      line_extreme(line.data(), result.data(), rows, 1, radius, better, worst, scratch);
      for (std::size_t r = 0; r < rows; ++r) values[r * columns + c] = result[r];
    }
  });
}

template <typename T>
T least(T a, T b) {
  return std::min(a, b);
}
template <typename T>
T largest(T a, T b) {
  return std::max(a, b);
}

}  // namespace

void fill_all(Grid<float>& grid, int rounds) {
  std::vector<std::size_t> filled;
  Level finest;
  finest.rows = grid.geometry.rows;
  finest.columns = grid.geometry.columns;
  finest.value = grid.values;
  finest.known.resize(grid.values.size());
  for (std::size_t k = 0; k < grid.values.size(); ++k) {
    finest.known[k] = std::isfinite(grid.values[k]) ? 1 : 0;
    if (finest.known[k] == 0) filled.push_back(k);
  }
  if (filled.empty() || filled.size() == grid.values.size()) return;
  std::vector<Level> levels;
  levels.push_back(std::move(finest));
  while (std::find(levels.back().known.begin(), levels.back().known.end(), 0) != levels.back().known.end())
    levels.push_back(coarser(levels.back()));
  for (std::size_t l = levels.size() - 1; l-- > 0;) {
    Level& fine = levels[l];
    const Level& coarse = levels[l + 1];
    base::parallel_for(fine.rows, kRows, [&](std::size_t begin, std::size_t end) {
      for (std::size_t r = begin; r < end; ++r)
        for (std::size_t c = 0; c < fine.columns; ++c)
          if (fine.known[r * fine.columns + c] == 0) fine.value[r * fine.columns + c] = sample(coarse, r, c);
    });
  }
  for (const std::size_t k : filled) grid.values[k] = levels.front().value[k];
  relax(grid, filled, rounds);
}

Grid<std::uint8_t> closed_mask(const Grid<std::uint8_t>& mask, std::size_t reach) {
  Grid<std::uint8_t> result = mask;
  if (reach == 0) return result;
  const std::size_t rows = mask.geometry.rows, columns = mask.geometry.columns;
  // Beyond the border nothing is known: the dilation sees 0 there; the erosion must not eat in from it.
  square_extreme<std::uint8_t>(result.values, rows, columns, reach, largest<std::uint8_t>, 0);
  square_extreme<std::uint8_t>(result.values, rows, columns, reach, least<std::uint8_t>, 1);
  return result;
}

Grid<float> opened(const Grid<float>& heights, std::size_t radius) {
  Grid<float> result = heights;
  constexpr float kInf = std::numeric_limits<float>::infinity();
  const std::size_t rows = heights.geometry.rows, columns = heights.geometry.columns;
  square_extreme<float>(result.values, rows, columns, radius, least<float>, kInf);
  square_extreme<float>(result.values, rows, columns, radius, largest<float>, -kInf);
  return result;
}

std::size_t clamped_cell(const geometry::GridGeometry& g, const geometry::Vec2& p) {
  const auto index = [](double at, std::size_t count) {
    return static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(count - 1)));
  };
  return index((g.north - p.y()) / g.cell, g.rows) * g.columns + index((p.x() - g.west) / g.cell, g.columns);
}

}  // namespace cairn::segmentation
