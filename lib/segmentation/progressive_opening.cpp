#include "segmentation/progressive_opening.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

#include "base/parallel.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Grid;

constexpr std::size_t kRows = 32;
constexpr std::size_t kStrip = 64;  // columns taken together: a strip of 1000 rows stays in the second cache

struct Least {
  static float of(float a, float b) { return a < b ? a : b; }
  static constexpr float kWorst = std::numeric_limits<float>::infinity();
};
struct Largest {
  static float of(float a, float b) { return a > b ? a : b; }
  static constexpr float kWorst = -std::numeric_limits<float>::infinity();
};

// out[i] = better(in[i], in[i + shift]) for i < count; apart, so that the compiler may use vectors.
template <typename Better>
void combine(const float* __restrict in, float* __restrict out, std::size_t count, std::size_t shift) {
  for (std::size_t i = 0; i < count; ++i) out[i] = Better::of(in[i], in[i + shift]);
}

// Extreme over windows of `window` items of `length` + window - 1 items; items are `width` floats wide. Windows are
// doubled: log2(window) passes. Returns which of the two buffers holds the result.
template <typename Better>
float* windowed(float* a, float* b, std::size_t length, std::size_t window, std::size_t width) {
  std::size_t covered = 1;
  while (covered < window) {
    const std::size_t shift = std::min(covered, window - covered);
    const std::size_t left = length + window - covered - shift;
    combine<Better>(a, b, left * width, shift * width);
    std::swap(a, b);
    covered += shift;
  }
  return a;
}

template <typename Better>
void square_extreme(std::vector<float>& values, std::size_t rows, std::size_t columns, std::size_t radius) {
  const std::size_t window = 2 * radius + 1;
  base::parallel_for(rows, kRows, [&](std::size_t begin, std::size_t end) {
    std::vector<float> first(columns + 2 * radius), second(columns + 2 * radius);
    for (std::size_t r = begin; r < end; ++r) {
      float* row = values.data() + r * columns;
      std::fill_n(first.begin(), radius, Better::kWorst);
      std::copy_n(row, columns, first.data() + radius);
      std::fill_n(first.data() + radius + columns, radius, Better::kWorst);
      std::copy_n(windowed<Better>(first.data(), second.data(), columns, window, 1), columns, row);
    }
  });
  base::parallel_for(columns, kStrip, [&](std::size_t begin, std::size_t end) {
    const std::size_t width = end - begin;
    std::vector<float> first((rows + 2 * radius) * width, Better::kWorst), second(first.size());
    for (std::size_t r = 0; r < rows; ++r)
      std::copy_n(values.data() + r * columns + begin, width, first.data() + (r + radius) * width);
    const float* result = windowed<Better>(first.data(), second.data(), rows, window, width);
    for (std::size_t r = 0; r < rows; ++r) std::copy_n(result + r * width, width, values.data() + r * columns + begin);
  });
}

// Heights with a border of `width` cells, reflected at the edge's height so that a slope goes on: a flat window
// that met the edge would cut off its uphill side.
Grid<float> with_border(const Grid<float>& inner, std::size_t width) {
  const auto& g = inner.geometry;
  Grid<float> outer({g.west, g.north, g.cell, g.columns + 2 * width, g.rows + 2 * width}, 0.0F);
  // Place of index i - width in 0..count-1: the edge, and its mirror image inside.
  const auto place = [width](std::size_t i, std::size_t count) {
    const auto last = static_cast<std::ptrdiff_t>(count) - 1;
    const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(i) - static_cast<std::ptrdiff_t>(width);
    const std::ptrdiff_t edge = std::clamp<std::ptrdiff_t>(at, 0, last);
    const std::ptrdiff_t mirror = std::clamp<std::ptrdiff_t>(2 * edge - at, 0, last);
    return std::pair(static_cast<std::size_t>(edge), static_cast<std::size_t>(mirror));
  };
  for (std::size_t r = 0; r < outer.geometry.rows; ++r) {
    const auto [edge_row, row] = place(r, g.rows);
    for (std::size_t c = 0; c < outer.geometry.columns; ++c) {
      const auto [edge_column, column] = place(c, g.columns);
      outer.at(r, c) = edge_row == row && edge_column == column
                           ? inner.at(row, column)
                           : 2.0F * inner.at(edge_row, edge_column) - inner.at(row, column);
    }
  }
  return outer;
}

std::size_t next_radius(std::size_t radius) {
  return radius < 6 ? radius + 1 : radius + (radius + 2) / 5;
}

}  // namespace

Grid<std::uint8_t> object_cells(const Grid<float>& heights, std::size_t radius, double slope) {
  const auto& g = heights.geometry;
  Grid<std::uint8_t> result(g, 0);
  if (radius == 0 || g.cells() == 0) return result;
  Grid<float> eroded = with_border(heights, radius);
  const std::size_t rows = eroded.geometry.rows, columns = eroded.geometry.columns;
  std::vector<float> before = eroded.values;
  std::vector<float> opening;
  // Openings by squares absorb: the opening of the original by the larger one equals that of the smaller opening. So
  // the erosion is carried on from radius to radius, and only the dilation starts anew.
  std::size_t reached = 0;
  for (std::size_t r = 1;; r = next_radius(r)) {
    const std::size_t now = std::min(r, radius);
    square_extreme<Least>(eroded.values, rows, columns, now - reached);
    opening = eroded.values;
    square_extreme<Largest>(opening, rows, columns, now);
    const auto allowed = static_cast<float>(slope * g.cell * static_cast<double>(now));
    base::parallel_for(g.rows, kRows, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const float* old_row = before.data() + (i + radius) * columns + radius;
        const float* new_row = opening.data() + (i + radius) * columns + radius;
        std::uint8_t* out = result.values.data() + i * g.columns;
        for (std::size_t c = 0; c < g.columns; ++c) out[c] |= old_row[c] - new_row[c] > allowed ? 1 : 0;
      }
    });
    std::swap(before, opening);
    reached = now;
    if (now == radius) return result;
  }
}

}  // namespace cairn::segmentation
