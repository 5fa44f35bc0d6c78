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

}  // namespace

geometry::GreyImage read_grey_image(const std::filesystem::path& path, std::int64_t max_width_px) {
  const ImageHeader header = read_image_header(path);
  constexpr std::int64_t kMaxPixels = 400'000'000;
  if (header.width_px > kMaxPixels / header.height_px)
    throw base::Error(base::ErrorCode::invalid_input, "the image is too large")
        .file(path.string())
        .found(std::to_string(header.width_px) + " x " + std::to_string(header.height_px))
        .allowed("at most 400 million pixels");
  const FileBytes file(path);
  const auto bytes = file.bytes();
  cv::Mat pixels;
  try {
    const cv::Mat encoded(1, static_cast<int>(std::min<std::size_t>(bytes.size(), INT32_MAX)), CV_8UC1,
                          const_cast<std::byte*>(bytes.data()));
    pixels = cv::imdecode(encoded, flags_for(header.width_px, max_width_px));
  } catch (const cv::Exception& error) {
    throw base::Error(base::ErrorCode::invalid_input, "the image cannot be decoded")
        .file(path.string())
        .found(error.err);
  }
  if (pixels.empty() || pixels.type() != CV_8UC1)
    throw base::Error(base::ErrorCode::invalid_input, "the image cannot be decoded")
        .file(path.string())
        .hint("Copy the image again from its source");
  geometry::GreyImage image;
  image.width_px = static_cast<std::size_t>(pixels.cols);
  image.height_px = static_cast<std::size_t>(pixels.rows);
  image.values.reserve(image.width_px * image.height_px);
  for (int r = 0; r < pixels.rows; ++r)
    image.values.insert(image.values.end(), pixels.ptr(r), pixels.ptr(r) + pixels.cols);
  return image;
}

}  // namespace cairn::io
