#include <algorithm>
#include <cctype>
#include <opencv2/imgcodecs.hpp>
#include <string_view>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "io/bytes.hpp"
#include "io/image.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;

constexpr std::int64_t kMaxSide = 65'000;

void check_size(const std::filesystem::path& path, std::int64_t width, std::int64_t height, std::size_t channels,
                std::size_t values) {
  if (width >= 1 && height >= 1 && width <= kMaxSide && height <= kMaxSide &&
      channels * static_cast<std::size_t>(width) * static_cast<std::size_t>(height) == values)
    return;
  throw Error(ErrorCode::invalid_argument, "the size of the image does not fit its values")
      .file(path.string())
      .found(std::to_string(width) + " x " + std::to_string(height) + " pixels, " + std::to_string(values) + " values")
      .allowed("1 to 65000 a side, " + std::to_string(channels) + " values a pixel");
}

// Encoded in memory, so that the write is checked as every other.
void encode_and_write(const std::filesystem::path& path, const std::string& format, const cv::Mat& pixels,
                      const std::vector<int>& settings) {
  std::vector<unsigned char> bytes;
  bool coded = false;
  try {
    coded = cv::imencode(format, pixels, bytes, settings);
  } catch (const cv::Exception& error) {
    throw Error(ErrorCode::internal, "the image cannot be encoded").file(path.string()).found(error.err);
  }
  if (!coded) throw Error(ErrorCode::internal, "the image cannot be encoded").file(path.string());
  base::write_file(path, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

}  // namespace

void write_rgb_image(const std::filesystem::path& path, std::int64_t width_px, std::int64_t height_px,
                     std::span<const std::uint8_t> rgb, int jpeg_quality) {
  const std::string extension = lower_extension(path);
  const bool jpeg = extension == ".jpg" || extension == ".jpeg";
  if (!jpeg && extension != ".png")
    throw Error(ErrorCode::invalid_argument, "the image's format is not known")
        .file(path.string())
        .found(extension)
        .allowed(".png, .jpg, .jpeg");
  check_size(path, width_px, height_px, 3, rgb.size());
  cv::Mat bgr(static_cast<int>(height_px), static_cast<int>(width_px), CV_8UC3);
  for (int r = 0; r < bgr.rows; ++r) {
    const std::uint8_t* from = rgb.data() + 3 * static_cast<std::size_t>(r) * static_cast<std::size_t>(width_px);
    unsigned char* to = bgr.ptr(r);
    for (int c = 0; c < bgr.cols; ++c, from += 3, to += 3) {
      to[0] = from[2];
      to[1] = from[1];
      to[2] = from[0];
    }
  }
  if (jpeg) {
    encode_and_write(path, ".jpg", bgr, {cv::IMWRITE_JPEG_QUALITY, std::clamp(jpeg_quality, 1, 100)});
  } else {
    encode_and_write(path, ".png", bgr, {cv::IMWRITE_PNG_COMPRESSION, 3});
  }
}

void write_grey16_png(const std::filesystem::path& path, std::int64_t width_px, std::int64_t height_px,
                      std::span<const std::uint16_t> values) {
  check_size(path, width_px, height_px, 1, values.size());
  const cv::Mat pixels(static_cast<int>(height_px), static_cast<int>(width_px), CV_16UC1,
                       const_cast<std::uint16_t*>(values.data()));
  encode_and_write(path, ".png", pixels, {cv::IMWRITE_PNG_COMPRESSION, 3});
}

Grey16Image read_grey16_png(const std::filesystem::path& path) {
  const ImageHeader header = read_image_header(path);
  const auto refuse = [&path](const std::string& found) {
    return Error(ErrorCode::invalid_input, "the image is not a PNG of one 16-bit channel")
        .file(path.string())
        .found(found);
  };
  if (header.format != "PNG" || header.channels != 1) throw refuse(header.format);
  if (header.width_px > kMaxSide || header.height_px > kMaxSide) throw refuse("more than 65000 pixels a side");
  const FileBytes file(path);
  const auto bytes = file.bytes();
  cv::Mat pixels;
  try {
    const cv::Mat encoded(1, static_cast<int>(std::min<std::size_t>(bytes.size(), INT32_MAX)), CV_8UC1,
                          const_cast<std::byte*>(bytes.data()));
    pixels = cv::imdecode(encoded, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception& error) {
    throw refuse(error.err);
  }
  if (pixels.empty()) throw refuse("pixels that cannot be decoded");
  if (pixels.type() != CV_16UC1) throw refuse("8 bits a value");
  Grey16Image image{pixels.cols, pixels.rows, {}};
  image.values.reserve(pixels.total());
  for (int r = 0; r < pixels.rows; ++r) {
    const auto* row = pixels.ptr<std::uint16_t>(r);
    image.values.insert(image.values.end(), row, row + pixels.cols);
  }
  return image;
}

}  // namespace cairn::io
