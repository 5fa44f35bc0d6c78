#include <opencv2/calib3d.hpp>

#include "adjustment/feature_matches.hpp"
#include "adjustment/image_features.hpp"
#include "base/parallel.hpp"

namespace cairn::adjustment {
namespace {

cv::Point2f as_point(const geometry::Vec2& pixel) {
  return {static_cast<float>(pixel.x()), static_cast<float>(pixel.y())};
}

std::vector<PixelMatch> match(const ImageFeatures& a, const ImageFeatures& b, const MatchOptions& options) {
  const auto paired = pair_features(a, b, options.ratio);
  if (paired.size() < static_cast<std::size_t>(options.min_inliers)) return {};
  std::vector<cv::Point2f> from, to;
  for (const auto& pair : paired) {
    from.push_back(as_point(a.pixels[pair.a]));
    to.push_back(as_point(b.pixels[pair.b]));
  }
  std::vector<std::uint8_t> inlier;
  constexpr int kRounds = 2000;
  constexpr double kConfidence = 0.999;
  cv::findHomography(from, to, cv::RANSAC, options.ransac_px_per_width * b.width_px, inlier, kRounds, kConfidence);
  std::vector<PixelMatch> result;
  for (std::size_t i = 0; i < inlier.size(); ++i)
    if (inlier[i] != 0) result.push_back({a.pixels[paired[i].a], b.pixels[paired[i].b]});
  if (result.size() < static_cast<std::size_t>(options.min_inliers)) return {};
  return result;
}

}  // namespace

std::vector<std::vector<PixelMatch>> match_images(std::span<const geometry::GreyImage> images,
                                                  std::span<const std::pair<std::size_t, std::size_t>> pairs,
                                                  const MatchOptions& options) {
  auto checked = options;
  base::validate(base::bind_options(checked), "feature matching");
  std::vector<ImageFeatures> features(images.size());
  base::parallel_for(images.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      features[i] = image_features(images[i], options.max_width_px, options.max_features);
  });
  std::vector<std::vector<PixelMatch>> result(pairs.size());
  base::parallel_for(pairs.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      result[i] = match(features[pairs[i].first], features[pairs[i].second], options);
  });
  return result;
}

}  // namespace cairn::adjustment
