// Three-channel pixels as plain data; decoding files is the business of module `io`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cairn::geometry {

// Rows from the top, raw (un-rotated) image; red, green, blue of each pixel.
struct ColourImage {
  std::size_t width_px = 0, height_px = 0;
  std::vector<std::uint8_t> values;  // row-major, 3 * width_px * height_px
};

}  // namespace cairn::geometry
