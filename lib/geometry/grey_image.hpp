// One-channel pixels as plain data; decoding files is the business of module `io`.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/vec.hpp"

namespace cairn::geometry {

// Rows from the top, raw (un-rotated) image, corner convention: the first pixel's centre is (0.5, 0.5).
struct GreyImage {
  std::size_t width_px = 0, height_px = 0;
  std::vector<std::uint8_t> values;  // row-major, width_px * height_px

  [[nodiscard]] std::uint8_t at(std::size_t row, std::size_t column) const { return values[row * width_px + column]; }

  // Bilinear between pixel centres; empty where one of the four pixels lies outside.
  [[nodiscard]] std::optional<double> sample(const Vec2& pixel) const {
    const double x = pixel.x() - 0.5, y = pixel.y() - 0.5;
    if (!(x >= 0.0 && y >= 0.0 && width_px > 1 && height_px > 1)) return std::nullopt;
    const auto column = static_cast<std::size_t>(x), row = static_cast<std::size_t>(y);
    if (column + 1 >= width_px || row + 1 >= height_px) return std::nullopt;
    const double u = x - static_cast<double>(column), v = y - static_cast<double>(row);
    const double top = (1.0 - u) * at(row, column) + u * at(row, column + 1);
    const double bottom = (1.0 - u) * at(row + 1, column) + u * at(row + 1, column + 1);
    return (1.0 - v) * top + v * bottom;
  }
};

}  // namespace cairn::geometry
