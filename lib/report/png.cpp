#include "report/png.hpp"

#include <cstdlib>
#include <string_view>

#include "base/error.hpp"
#include "report/deflate.hpp"

namespace cairn::report {
namespace {

void put_u32(std::string& out, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(value >> shift & 0xFFU);
}

void put_chunk(std::string& out, std::string_view type, std::string_view body) {
  put_u32(out, static_cast<std::uint32_t>(body.size()));
  std::string checked(type);
  checked += body;
  out += checked;
  put_u32(out, crc32_of(checked));
}

std::string header(std::size_t width, std::size_t height, std::uint8_t colour_type) {
  if (width == 0 || height == 0 || width > 100000 || height > 100000)
    throw base::Error(base::ErrorCode::failed_precondition, "an image of the report has no drawable size")
        .found(std::to_string(width) + " x " + std::to_string(height));
  std::string out("\x89PNG\r\n\x1a\n", 8);
  std::string body;
  put_u32(body, static_cast<std::uint32_t>(width));
  put_u32(body, static_cast<std::uint32_t>(height));
  body += static_cast<char>(8);
  body += static_cast<char>(colour_type);
  body.append(3, '\0');
  put_chunk(out, "IHDR", body);
  return out;
}

void finish(std::string& out, std::string_view filtered) {
  put_chunk(out, "IDAT", zlib_compressed(filtered));
  put_chunk(out, "IEND", "");
}

int paeth(int left, int up, int corner) {
  const int p = left + up - corner;
  const int a = std::abs(p - left), b = std::abs(p - up), c = std::abs(p - corner);
  return a <= b && a <= c ? left : b <= c ? up : corner;
}

}  // namespace

std::string encode_png(const IndexedImage& image) {
  std::string out = header(image.width, image.height, 3);
  std::string colours, alphas;
  for (const Rgba& c : image.palette) {
    for (std::size_t k = 0; k < 3; ++k) colours += static_cast<char>(c[k]);
    alphas += static_cast<char>(c[3]);
  }
  put_chunk(out, "PLTE", colours);
  put_chunk(out, "tRNS", alphas);
  std::string rows;
  rows.reserve((image.width + 1) * image.height);
  for (std::size_t r = 0; r < image.height; ++r) {
    rows += '\0';  // palette indices are not smooth: no filter
    for (std::size_t c = 0; c < image.width; ++c) rows += static_cast<char>(image.pixels[r * image.width + c]);
  }
  finish(out, rows);
  return out;
}

std::string encode_png(const RgbaImage& image) {
  std::string out = header(image.width, image.height, 6);
  const std::size_t stride = image.width * 4;
  std::string rows;
  rows.reserve((stride + 1) * image.height);
  const auto at = [&](std::size_t row, std::size_t byte) -> int {
    return image.pixels[row * image.width + byte / 4][byte % 4];
  };
  for (std::size_t r = 0; r < image.height; ++r) {
    rows += '\4';  // Paeth: best on photographs and shaded relief
    for (std::size_t i = 0; i < stride; ++i) {
      const int left = i >= 4 ? at(r, i - 4) : 0;
      const int up = r > 0 ? at(r - 1, i) : 0;
      const int corner = i >= 4 && r > 0 ? at(r - 1, i - 4) : 0;
      rows += static_cast<char>((at(r, i) - paeth(left, up, corner)) & 0xFF);
    }
  }
  finish(out, rows);
  return out;
}

}  // namespace cairn::report
