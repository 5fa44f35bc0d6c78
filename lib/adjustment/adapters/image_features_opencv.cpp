#include <algorithm>
#include <numeric>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "adjustment/image_features.hpp"

namespace cairn::adjustment {

ImageFeatures image_features(const geometry::GreyImage& image, std::int64_t max_width_px, std::int64_t max_features,
                             bool ranked) {
  ImageFeatures result;
  result.width_px = static_cast<double>(image.width_px);
  result.height_px = static_cast<double>(image.height_px);
  if (image.values.empty()) return result;
  // OpenCV takes non-const data but does not write to it here.
  const cv::Mat full(static_cast<int>(image.height_px), static_cast<int>(image.width_px), CV_8UC1,
                     const_cast<std::uint8_t*>(image.values.data()));
  cv::Mat small = full;
  const double factor = std::min(1.0, static_cast<double>(max_width_px) / result.width_px);
  if (factor < 1.0) cv::resize(full, small, cv::Size(), factor, factor, cv::INTER_AREA);
  const double fx = static_cast<double>(full.cols) / small.cols, fy = static_cast<double>(full.rows) / small.rows;
  const auto sift = cv::SIFT::create(static_cast<int>(max_features));
  std::vector<cv::KeyPoint> points;
  cv::Mat descriptors;
  sift->detectAndCompute(small, cv::noArray(), points, descriptors);
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (ranked) {
    const auto same_place = [&](std::size_t x, std::size_t y) { return points[x].pt == points[y].pt; };
    // OpenCV lists the orientations of one place one after another.
    order.erase(std::unique(order.begin(), order.end(), same_place), order.end());
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t x, std::size_t y) { return points[x].response > points[y].response; });
  }
  for (const auto i : order) {
    // OpenCV counts from the first pixel's centre.
    result.pixels.emplace_back((static_cast<double>(points[i].pt.x) + 0.5) * fx,
                               (static_cast<double>(points[i].pt.y) + 0.5) * fy);
    // Integers of one byte by construction, as floats.
    const auto* row = descriptors.ptr<float>(static_cast<int>(i));
    for (std::size_t k = 0; k < kDescriptorBytes; ++k) result.descriptors.push_back(static_cast<std::uint8_t>(row[k]));
  }
  return result;
}

}  // namespace cairn::adjustment
