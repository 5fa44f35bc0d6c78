#include <algorithm>
#include <opencv2/imgcodecs.hpp>

#include "base/error.hpp"
#include "io/bytes.hpp"
#include "io/image.hpp"

namespace cairn::io {
namespace {

int flags_for(std::int64_t width, std::int64_t most) {
  const int raw = cv::IMREAD_IGNORE_ORIENTATION;
  if (most <= 0 || width <= most) return cv::IMREAD_GRAYSCALE | raw;
  if (width <= 2 * most) return cv::IMREAD_REDUCED_GRAYSCALE_2 | raw;
  if (width <= 4 * most) return cv::IMREAD_REDUCED_GRAYSCALE_4 | raw;
  return cv::IMREAD_REDUCED_GRAYSCALE_8 | raw;
}

// Pixels of the raw raster, of the cv type that `flags` ask for.
cv::Mat decoded(const std::filesystem::path& path, std::int64_t width_px, std::int64_t height_px, int flags, int type) {
  constexpr std::int64_t kMaxPixels = 400'000'000;
  if (width_px > kMaxPixels / height_px)
    throw base::Error(base::ErrorCode::invalid_input, "the image is too large")
        .file(path.string())
        .found(std::to_string(width_px) + " x " + std::to_string(height_px))
        .allowed("at most 400 million pixels");
  const FileBytes file(path);
  const auto bytes = file.bytes();
  cv::Mat pixels;
  try {
    const cv::Mat encoded(1, static_cast<int>(std::min<std::size_t>(bytes.size(), INT32_MAX)), CV_8UC1,
                          const_cast<std::byte*>(bytes.data()));
    pixels = cv::imdecode(encoded, flags);
  } catch (const cv::Exception& error) {
    throw base::Error(base::ErrorCode::invalid_input, "the image cannot be decoded")
        .file(path.string())
        .found(error.err);
  }
  if (pixels.empty() || pixels.type() != type)
    throw base::Error(base::ErrorCode::invalid_input, "the image cannot be decoded")
        .file(path.string())
        .hint("Copy the image again from its source");
  return pixels;
}

}  // namespace

geometry::GreyImage read_grey_image(const std::filesystem::path& path, std::int64_t max_width_px) {
  const ImageHeader header = read_image_header(path);
  const cv::Mat pixels =
      decoded(path, header.width_px, header.height_px, flags_for(header.width_px, max_width_px), CV_8UC1);
  geometry::GreyImage image;
  image.width_px = static_cast<std::size_t>(pixels.cols);
  image.height_px = static_cast<std::size_t>(pixels.rows);
  image.values.reserve(image.width_px * image.height_px);
  for (int r = 0; r < pixels.rows; ++r)
    image.values.insert(image.values.end(), pixels.ptr(r), pixels.ptr(r) + pixels.cols);
  return image;
}

geometry::ColourImage read_colour_image(const std::filesystem::path& path) {
  const ImageHeader header = read_image_header(path);
  const cv::Mat pixels =
      decoded(path, header.width_px, header.height_px, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION, CV_8UC3);
  geometry::ColourImage image;
  image.width_px = static_cast<std::size_t>(pixels.cols);
  image.height_px = static_cast<std::size_t>(pixels.rows);
  image.values.resize(3 * image.width_px * image.height_px);
  std::uint8_t* to = image.values.data();
  for (int r = 0; r < pixels.rows; ++r) {
    const std::uint8_t* from = pixels.ptr(r);
    for (int c = 0; c < pixels.cols; ++c, from += 3, to += 3) {
      to[0] = from[2];
      to[1] = from[1];
      to[2] = from[0];
    }
  }
  return image;
}

}  // namespace cairn::io
