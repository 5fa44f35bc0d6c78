#include <Eigen/Core>
#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "adjustment/feature_matches.hpp"
#include "base/parallel.hpp"

namespace cairn::adjustment {
namespace {

struct Features {
  std::vector<cv::Point2f> pixels;  // of the image given, corner convention
  cv::Mat descriptors;              // one row a feature, 32-bit float (RootSIFT)
  double width_px = 0.0;
};

// Square roots of L1-normalised descriptors: Arandjelovic and Zisserman 2012.
void to_root_sift(cv::Mat& descriptors) {
  for (int r = 0; r < descriptors.rows; ++r) {
    auto row = descriptors.row(r);
    const double sum = cv::norm(row, cv::NORM_L1);
    if (sum > 0.0) row /= sum;
    cv::sqrt(row, row);
  }
}

Features features_of(const geometry::GreyImage& image, const MatchOptions& options) {
  Features result;
  result.width_px = static_cast<double>(image.width_px);
  if (image.values.empty()) return result;
  // OpenCV takes non-const data but does not write to it here.
  const cv::Mat full(static_cast<int>(image.height_px), static_cast<int>(image.width_px), CV_8UC1,
                     const_cast<std::uint8_t*>(image.values.data()));
  cv::Mat small = full;
  const double factor = std::min(1.0, static_cast<double>(options.max_width_px) / result.width_px);
  if (factor < 1.0) cv::resize(full, small, cv::Size(), factor, factor, cv::INTER_AREA);
  const double fx = static_cast<double>(full.cols) / small.cols, fy = static_cast<double>(full.rows) / small.rows;
  const auto sift = cv::SIFT::create(static_cast<int>(options.max_features));
  std::vector<cv::KeyPoint> points;
  sift->detectAndCompute(small, cv::noArray(), points, result.descriptors);
  to_root_sift(result.descriptors);
  for (const auto& p : points)
    // OpenCV counts from the first pixel's centre.
    result.pixels.emplace_back(static_cast<float>((static_cast<double>(p.pt.x) + 0.5) * fx),
                               static_cast<float>((static_cast<double>(p.pt.y) + 0.5) * fy));
  return result;
}

// Largest and second-largest product of one feature, and whose the largest is.
struct Best {
  int index = -1;
  float first = -2.0F, second = -2.0F;

  void offer(int candidate, float product) {
    if (product > first) {
      second = first;
      first = product;
      index = candidate;
    } else if (product > second) {
      second = product;
    }
  }
  // Products of unit vectors: distance^2 = 2 - 2 product.
  [[nodiscard]] bool passes(double ratio) const {
    const double near = 2.0 - 2.0 * static_cast<double>(first), far = 2.0 - 2.0 * static_cast<double>(second);
    return index >= 0 && near < ratio * ratio * far;
  }
};

using Descriptors = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Eigen::Map<const Descriptors> mapped(const cv::Mat& m) {
  return {m.ptr<float>(), m.rows, m.cols};
}

std::vector<PixelMatch> match(const Features& a, const Features& b, const MatchOptions& options) {
  if (a.pixels.size() < 2 || b.pixels.size() < 2) return {};
  // Eigen's product is several times faster than cv::gemm where OpenCV has no BLAS.
  const Descriptors products = mapped(a.descriptors) * mapped(b.descriptors).transpose();
  std::vector<Best> of_a(a.pixels.size()), of_b(b.pixels.size());
  for (int i = 0; i < products.rows(); ++i)
    for (int j = 0; j < products.cols(); ++j) {
      of_a[static_cast<std::size_t>(i)].offer(j, products(i, j));
      of_b[static_cast<std::size_t>(j)].offer(i, products(i, j));
    }
  std::vector<cv::Point2f> from, to;
  for (std::size_t i = 0; i < of_a.size(); ++i) {
    if (!of_a[i].passes(options.ratio)) continue;
    const auto j = static_cast<std::size_t>(of_a[i].index);
    if (of_b[j].index != static_cast<int>(i) || !of_b[j].passes(options.ratio)) continue;
    from.push_back(a.pixels[i]);
    to.push_back(b.pixels[j]);
  }
  if (from.size() < static_cast<std::size_t>(options.min_inliers)) return {};
  std::vector<std::uint8_t> inlier;
  constexpr int kRounds = 2000;
  constexpr double kConfidence = 0.999;
  cv::findHomography(from, to, cv::RANSAC, options.ransac_px_per_width * b.width_px, inlier, kRounds, kConfidence);
  std::vector<PixelMatch> result;
  for (std::size_t i = 0; i < inlier.size(); ++i)
    if (inlier[i] != 0)
      result.push_back({{static_cast<double>(from[i].x), static_cast<double>(from[i].y)},
                        {static_cast<double>(to[i].x), static_cast<double>(to[i].y)}});
  if (result.size() < static_cast<std::size_t>(options.min_inliers)) return {};
  return result;
}

}  // namespace

std::vector<std::vector<PixelMatch>> match_images(std::span<const geometry::GreyImage> images,
                                                  std::span<const std::pair<std::size_t, std::size_t>> pairs,
                                                  const MatchOptions& options) {
  auto checked = options;
  base::validate(base::bind_options(checked), "feature matching");
  std::vector<Features> features(images.size());
  base::parallel_for(images.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) features[i] = features_of(images[i], options);
  });
  std::vector<std::vector<PixelMatch>> result(pairs.size());
  base::parallel_for(pairs.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      result[i] = match(features[pairs[i].first], features[pairs[i].second], options);
  });
  return result;
}

}  // namespace cairn::adjustment
