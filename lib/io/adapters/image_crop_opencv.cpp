#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "base/error.hpp"
#include "io/image.hpp"
#include "io/image_crop.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;

constexpr std::int64_t kMaxPixels = 400'000'000;

ImagePart crop(const cv::Mat& photograph, const geometry::PixelBox& box, const ImageCropOptions& o) {
  const double width = photograph.cols, height = photograph.rows;
  const geometry::Vec2 middle = box.centre();
  if (!(middle.x() >= 0.0 && middle.y() >= 0.0 && middle.x() < width && middle.y() < height)) return {};
  const double wanted =
      std::max(static_cast<double>(o.min_side_px), std::max(box.width(), box.height()) * (1.0 + 2.0 * o.margin));
  const int side = static_cast<int>(std::floor(std::min({wanted, width, height})));
  const auto corner = [side](double centre, double extent) {
    return static_cast<int>(std::floor(std::clamp(centre - 0.5 * side, 0.0, extent - side)));
  };
  const int x = corner(middle.x(), width), y = corner(middle.y(), height);
  cv::Mat part = photograph(cv::Rect(x, y, side, side)).clone();
  const int shown = static_cast<int>(std::min<std::int64_t>(side, o.max_side_px));
  if (shown < side) cv::resize(part, part, cv::Size(shown, shown), 0, 0, cv::INTER_AREA);
  if (o.outline) {
    const double scale = static_cast<double>(shown) / side;
    const auto pixel = [scale](double value, int origin) {
      return static_cast<int>(std::lround((value - origin) * scale));
    };
    const cv::Rect outline(cv::Point(pixel(box.xmin, x), pixel(box.ymin, y)),
                           cv::Point(pixel(box.xmax, x), pixel(box.ymax, y)));
    cv::rectangle(part, outline + cv::Point(1, 1), cv::Scalar(30, 30, 30), 1);
    cv::rectangle(part, outline, cv::Scalar(255, 255, 255), 1);
  }
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".jpg", part, bytes, {cv::IMWRITE_JPEG_QUALITY, static_cast<int>(o.quality)})) return {};
  return {{bytes.begin(), bytes.end()},
          static_cast<double>(x),
          static_cast<double>(y),
          static_cast<double>(shown) / side,
          static_cast<double>(shown)};
}

}  // namespace

std::vector<ImagePart> crop_parts(const std::filesystem::path& photograph, const std::vector<geometry::PixelBox>& boxes,
                                  const ImageCropOptions& options) {
  const ImageHeader header = read_image_header(photograph);
  if (header.width_px > kMaxPixels / header.height_px)
    throw Error(ErrorCode::invalid_input, "the photograph is too large")
        .file(photograph.string())
        .found(std::to_string(header.width_px) + " x " + std::to_string(header.height_px))
        .allowed("400 million pixels");
  cv::Mat image;
  try {
    image = cv::imread(photograph.string(), cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    image = cv::Mat();
  }
  if (image.empty())
    throw Error(ErrorCode::invalid_input, "the photograph cannot be decoded").file(photograph.string());
  std::vector<ImagePart> out;
  for (const geometry::PixelBox& box : boxes) out.push_back(crop(image, box, options));
  return out;
}

std::vector<std::string> crop_jpegs(const std::filesystem::path& photograph,
                                    const std::vector<geometry::PixelBox>& boxes, const ImageCropOptions& options) {
  std::vector<std::string> out;
  for (ImagePart& part : crop_parts(photograph, boxes, options)) out.push_back(std::move(part.jpeg));
  return out;
}

}  // namespace cairn::io
