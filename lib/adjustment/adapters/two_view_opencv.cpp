#include <opencv2/calib3d.hpp>

#include "adjustment/two_view.hpp"

namespace cairn::adjustment {
namespace {

constexpr double kConfidence = 0.999;
constexpr int kEssentialRounds = 1000, kHomographyRounds = 2000;

std::size_t count(const std::vector<std::uint8_t>& mask) {
  std::size_t n = 0;
  for (const auto m : mask) n += m != 0 ? 1U : 0U;
  return n;
}

// Within `distance` of where the homography puts the match, in image b.
std::vector<std::uint8_t> near_homography(const cv::Mat& h, std::span<const RayMatch> matches, double distance) {
  std::vector<std::uint8_t> near(matches.size(), 0);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const auto& [a, b] = matches[i];
    const auto row = [&](int r) {
      return h.at<double>(r, 0) * a.x() + h.at<double>(r, 1) * a.y() + h.at<double>(r, 2);
    };
    const double w = row(2);
    const geometry::Vec2 expected(row(0) / w, row(1) / w);
    near[i] = (expected - b).norm() <= distance ? 1 : 0;
  }
  return near;
}

}  // namespace

std::string_view name_of(TwoViewModel model) {
  switch (model) {
    case TwoViewModel::none: return "none";
    case TwoViewModel::essential: return "essential";
    case TwoViewModel::planar: return "planar";
  }
  return "";
}

TwoView verify_two_views(std::span<const RayMatch> matches, const TwoViewOptions& options) {
  TwoView result;
  result.inlier.assign(matches.size(), 0);
  if (matches.size() < std::max<std::size_t>(options.min_inliers, 8)) return result;
  std::vector<cv::Point2d> a, b;
  for (const auto& match : matches) {
    a.emplace_back(match.a.x(), match.a.y());
    b.emplace_back(match.b.x(), match.b.y());
  }
  std::vector<std::uint8_t> by_essential, by_homography;
  const cv::Mat e = cv::findEssentialMat(a, b, cv::Mat::eye(3, 3, CV_64F), cv::RANSAC, kConfidence, options.epipolar,
                                         kEssentialRounds, by_essential);
  const cv::Mat h =
      cv::findHomography(a, b, cv::RANSAC, 2.0 * options.epipolar, by_homography, kHomographyRounds, kConfidence);
  if (e.empty() || by_essential.size() != matches.size()) return result;
  result.essential_inliers = count(by_essential);
  result.homography_inliers = h.empty() ? 0 : count(by_homography);
  result.model = TwoViewModel::essential;
  result.inlier = by_essential;
  if (static_cast<double>(result.homography_inliers) >=
      options.planar_share * static_cast<double>(result.essential_inliers)) {
    result.model = TwoViewModel::planar;
    const auto near = near_homography(h, matches, options.relief);
    for (std::size_t i = 0; i < near.size(); ++i) result.inlier[i] &= near[i];
  }
  result.inliers = count(result.inlier);
  if (result.inliers < options.min_inliers ||
      static_cast<double>(result.inliers) < options.min_inlier_share * static_cast<double>(matches.size())) {
    result.model = TwoViewModel::none;
    result.inlier.assign(matches.size(), 0);
    result.inliers = 0;
  }
  return result;
}

}  // namespace cairn::adjustment
