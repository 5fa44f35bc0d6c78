// PNG files in memory (ISO/IEC 15948), just what the page needs.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace cairn::report {

using Rgba = std::array<std::uint8_t, 4>;

// One byte a pixel into a palette of at most 256 colours, rows from the top.
struct IndexedImage {
  std::size_t width = 0, height = 0;
  std::vector<Rgba> palette;
  std::vector<std::uint8_t> pixels;
};

// Four bytes a pixel, not premultiplied.
struct RgbaImage {
  std::size_t width = 0, height = 0;
  std::vector<Rgba> pixels;
};

[[nodiscard]] std::string encode_png(const IndexedImage& image);
[[nodiscard]] std::string encode_png(const RgbaImage& image);

}  // namespace cairn::report
