// The image of a ROS map as brightness and opacity: PGM, PNG and BMP.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace cairn::io {

struct MapImage {
  std::size_t columns = 0, rows = 0;
  unsigned maximum = 255;  // of a channel
  // Red, green and blue of a pixel added up; three times the grey of a grey image. Row-major from the top.
  std::vector<std::uint16_t> colour;
  std::vector<std::uint8_t> opacity;  // 0..maximum; empty = the image has no such channel
};

// By content: binary PGM (P5) of up to 8 bits, PNG of 8 bits or less a channel, BMP. Throws invalid_input with the byte
// where the image is truncated or of another kind, or has more than 2^31 pixels.
[[nodiscard]] MapImage read_map_image(const std::filesystem::path& path);

// PNG of grey with opacity. Throws resource_exhausted where it cannot be written.
void write_map_png(const std::filesystem::path& path, std::size_t columns, std::size_t rows,
                   std::span<const std::uint8_t> grey, std::span<const std::uint8_t> opacity);

}  // namespace cairn::io
