// Photographs: their size from the first bytes, their brightness as pixels.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "geometry/colour_image.hpp"
#include "geometry/grey_image.hpp"

namespace cairn::io {

struct ImageHeader {
  std::string format;  // "JPEG", "PNG"
  std::int64_t width_px = 0, height_px = 0;
  int channels = 0;
  std::uint64_t file_bytes = 0;
};

// Reads the frame header of a JPEG (ITU-T T.81, B.2.2) or the IHDR of a PNG (RFC 2083, 4.1.1); no pixels
// are decoded. Throws not_found, or invalid_input with the offset: another format, a truncated header, a
// size of 0. A JPEG must also end with its end-of-image marker (padding after it is accepted), a PNG with
// its IEND chunk, so that a file cut short is found without decoding it.
// Cost: a few kilobytes read.
[[nodiscard]] ImageHeader read_image_header(const std::filesystem::path& path);

// Brightness of the raw raster: the EXIF orientation is not applied. Images wider than max_width_px are
// decoded at 1/2, 1/4 or 1/8 (JPEG: nearly for free), the largest fraction that is not wider; 0 = full
// size. Images above 400 Mpx are refused. Throws as above, and invalid_input where decoding fails.
[[nodiscard]] geometry::GreyImage read_grey_image(const std::filesystem::path& path, std::int64_t max_width_px = 0);

// Red, green, blue of the raw raster, at full size; grey images have three equal channels. Refuses as above.
[[nodiscard]] geometry::ColourImage read_colour_image(const std::filesystem::path& path);

// Red, green, blue of each pixel, row-major from the top. By the name's extension: .png (lossless), or .jpg / .jpeg
// of the given quality (1..100). Throws invalid_argument for another extension or a size that does not fit the
// values, resource_exhausted where the disk is full.
void write_rgb_image(const std::filesystem::path& path, std::int64_t width_px, std::int64_t height_px,
                     std::span<const std::uint8_t> rgb, int jpeg_quality = 92);

// One 16-bit value a pixel: depth in millimetres, instance masks.
struct Grey16Image {
  std::int64_t width_px = 0, height_px = 0;
  std::vector<std::uint16_t> values;  // row-major
};

// PNG of one 16-bit channel. Throws as above.
void write_grey16_png(const std::filesystem::path& path, std::int64_t width_px, std::int64_t height_px,
                      std::span<const std::uint16_t> values);
// Throws invalid_input where the file is not a PNG of one 16-bit channel.
[[nodiscard]] Grey16Image read_grey16_png(const std::filesystem::path& path);

}  // namespace cairn::io
