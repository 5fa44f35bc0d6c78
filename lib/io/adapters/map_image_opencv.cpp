#include <opencv2/imgcodecs.hpp>
#include <string>
#include <string_view>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "io/bytes.hpp"
#include "io/map_image.hpp"
#include "io/pgm.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;

constexpr std::size_t kMaxPixels = std::size_t{1} << 31U;

std::uint32_t number_at(Bytes bytes, std::size_t at, bool big_endian) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i)
    value = (value << 8U) | std::to_integer<std::uint32_t>(bytes[at + (big_endian ? i : 3 - i)]);
  return value;
}

// Width and height from the header, so that nothing is decoded that claims more pixels than its bytes can justify.
void check_size(const std::filesystem::path& path, Bytes bytes, bool png) {
  const std::size_t at = png ? 16 : 18;
  if (bytes.size() < at + 8) throw Error(ErrorCode::invalid_input, "an image that is cut off").file(path.string());
  const std::uint64_t width = number_at(bytes, at, png), height = number_at(bytes, at + 4, png) & 0x7fffffffU;
  constexpr std::uint64_t kBestRatio = 9000;  // pixels of one bit a byte, with DEFLATE's 1032:1
  if (width == 0 || height == 0 || width > 0x7fffffffU || height > kMaxPixels / width ||
      width * height > bytes.size() * kBestRatio)
    throw Error(ErrorCode::invalid_input, "an image with fewer pixels than its header says")
        .file(path.string())
        .found(std::to_string(width) + " x " + std::to_string(height) + " in " + std::to_string(bytes.size()) +
               " bytes");
}

// libpng prints what it thinks of a file that ends early.
void check_end(const std::filesystem::path& path, std::string_view text) {
  if (text.size() < 12 || text.substr(text.size() - 12).find("IEND") == std::string_view::npos)
    throw Error(ErrorCode::invalid_input, "an image that is cut off")
        .file(path.string())
        .hint("Copy the image again from its source");
}

cv::Mat decoded(const std::filesystem::path& path, Bytes bytes) {
  cv::Mat pixels;
  std::string reason;
  try {
    const cv::Mat encoded(1, static_cast<int>(std::min<std::size_t>(bytes.size(), INT32_MAX)), CV_8UC1,
                          const_cast<std::byte*>(bytes.data()));
    pixels = cv::imdecode(encoded, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception& error) {
    reason = error.err;
  }
  if (pixels.empty())
    throw Error(ErrorCode::invalid_input, "a map image that cannot be decoded").file(path.string()).found(reason);
  if (pixels.depth() != CV_8U)
    throw Error(ErrorCode::invalid_input, "a map image of more than 8 bits a channel").file(path.string());
  return pixels;
}

}  // namespace

MapImage read_map_image(const std::filesystem::path& path) {
  const FileBytes file(path);
  const std::string_view text = file.text();
  const bool png = text.rfind("\x89PNG\r\n\x1a\n", 0) == 0, bmp = text.rfind("BM", 0) == 0;
  if (!png && !bmp) return read_pgm(path.string(), text);
  check_size(path, file.bytes(), png);
  if (png) check_end(path, text);
  const cv::Mat pixels = decoded(path, file.bytes());
  const int channels = pixels.channels();
  MapImage image;
  image.columns = static_cast<std::size_t>(pixels.cols);
  image.rows = static_cast<std::size_t>(pixels.rows);
  image.colour.reserve(pixels.total());
  // The fourth channel of a BMP is a filler.
  const bool opacity = png && channels == 4;
  if (opacity) image.opacity.reserve(pixels.total());
  for (int r = 0; r < pixels.rows; ++r) {
    const unsigned char* pixel = pixels.ptr(r);
    for (int c = 0; c < pixels.cols; ++c, pixel += channels) {
      const int sum = channels < 3 ? 3 * pixel[0] : pixel[0] + pixel[1] + pixel[2];
      image.colour.push_back(static_cast<std::uint16_t>(sum));
      if (opacity) image.opacity.push_back(pixel[3]);
    }
  }
  return image;
}

void write_map_png(const std::filesystem::path& path, std::size_t columns, std::size_t rows,
                   std::span<const std::uint8_t> grey, std::span<const std::uint8_t> opacity) {
  constexpr std::size_t kMaxSide = 65'000;
  if (columns == 0 || rows == 0 || columns > kMaxSide || rows > kMaxSide || grey.size() != columns * rows ||
      opacity.size() != grey.size())
    throw Error(ErrorCode::invalid_argument, "a PNG map of a size that cannot be written")
        .file(path.string())
        .found(std::to_string(columns) + " x " + std::to_string(rows))
        .allowed("1 to 65000 a side");
  cv::Mat pixels(static_cast<int>(rows), static_cast<int>(columns), CV_8UC4);
  for (std::size_t i = 0; i < grey.size(); ++i) {
    unsigned char* pixel = pixels.data + 4 * i;
    pixel[0] = pixel[1] = pixel[2] = grey[i];
    pixel[3] = opacity[i];
  }
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".png", pixels, bytes, {cv::IMWRITE_PNG_COMPRESSION, 6}))
    throw Error(ErrorCode::internal, "the map image cannot be encoded").file(path.string());
  base::write_file(path, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

}  // namespace cairn::io
