// A raster in the local frame: geometry apart from values.
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "geometry/vec.hpp"

namespace cairn::geometry {

// North-up: row 0 is the northernmost, column 0 the westernmost.
struct GridGeometry {
  double west = 0.0;   // east coordinate of the western border, m, local frame
  double north = 0.0;  // north coordinate of the northern border, m, local frame
  double cell = 1.0;   // edge of a square cell, m, > 0
  std::size_t columns = 0, rows = 0;

  [[nodiscard]] std::size_t cells() const { return columns * rows; }
  [[nodiscard]] double east() const { return west + cell * static_cast<double>(columns); }
  [[nodiscard]] double south() const { return north - cell * static_cast<double>(rows); }
  [[nodiscard]] Vec2 centre(std::size_t row, std::size_t column) const {
    return {west + cell * (static_cast<double>(column) + 0.5), north - cell * (static_cast<double>(row) + 0.5)};
  }
  // Row and column of the cell that holds (east, north); empty outside.
  // A cell owns its western and northern border.
  [[nodiscard]] std::optional<std::pair<std::size_t, std::size_t>> cell_at(const Vec2& p) const {
    const double c = std::floor((p.x() - west) / cell);
    const double r = std::floor((north - p.y()) / cell);
    if (!(c >= 0.0 && r >= 0.0 && c < static_cast<double>(columns) && r < static_cast<double>(rows)))
      return std::nullopt;
    return std::pair(static_cast<std::size_t>(r), static_cast<std::size_t>(c));
  }
  friend bool operator==(const GridGeometry&, const GridGeometry&) = default;
};

// Smallest grid of whole cells, aligned to multiples of `cell`, that covers the two corners.
[[nodiscard]] inline GridGeometry covering_grid(const Vec2& min, const Vec2& max, double cell) {
  const double west = std::floor(min.x() / cell) * cell;
  const double north = std::ceil(max.y() / cell) * cell;
  const auto count = [cell](double extent) {
    return static_cast<std::size_t>(std::max(1.0, std::ceil(extent / cell - 1e-9)));
  };
  return {west, north, cell, count(max.x() - west), count(north - min.y())};
}

template <typename T>
struct Grid {
  GridGeometry geometry;
  std::vector<T> values;  // row-major, rows north to south; size geometry.cells()

  Grid() = default;
  Grid(const GridGeometry& g, T fill) : geometry(g), values(g.cells(), fill) {}

  [[nodiscard]] T& at(std::size_t row, std::size_t column) { return values[row * geometry.columns + column]; }
  [[nodiscard]] const T& at(std::size_t row, std::size_t column) const {
    return values[row * geometry.columns + column];
  }
};

}  // namespace cairn::geometry
