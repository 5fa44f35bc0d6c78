// Points that look the same in two images.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "base/options.hpp"
#include "geometry/grey_image.hpp"
#include "geometry/vec.hpp"

namespace cairn::adjustment {

struct MatchOptions {
  std::int64_t max_width_px = 1000;    // images wider than this are shrunk first (by area)
  std::int64_t max_features = 2000;    // strongest kept per image
  double ratio = 0.8;                  // Lowe's ratio: best distance / second best
  double ransac_px_per_width = 0.006;  // inlier distance of the homography, as a fraction of the image width
  std::int64_t min_inliers = 15;       // fewer: no matches are returned for the pair

  void visit(base::OptionVisitor& v) {
    v.integer("match-max-width-px", max_width_px, 200, 20000, "images are shrunk to this width before matching [px]");
    v.integer("match-max-features", max_features, 100, 100000, "strongest features kept per image");
    v.real("match-ratio", ratio, 0.1, 1.0, "largest ratio of best to second-best descriptor distance");
    v.real("match-ransac-px-per-width", ransac_px_per_width, 0.0005, 0.1,
           "inlier distance of the homography as a fraction of the image width");
    v.integer("match-min-inliers", min_inliers, 6, 100000, "pairs with fewer consistent matches are left out");
  }
};

struct PixelMatch {
  geometry::Vec2 a = geometry::Vec2::Zero();  // px of the image given, corner convention
  geometry::Vec2 b = geometry::Vec2::Zero();
};

// SIFT (Lowe 2004), ratio test both ways, and a homography by RANSAC (ground seen from above is nearly a
// plane); the homography's inliers are returned in the order of the features of image a. One result a
// pair, empty where the images do not match. The same on every run.
// Cost: about 0.25 s an image and 0.05 s a pair at the defaults on one core.
[[nodiscard]] std::vector<std::vector<PixelMatch>> match_images(
    std::span<const geometry::GreyImage> images, std::span<const std::pair<std::size_t, std::size_t>> pairs,
    const MatchOptions& options = {});

}  // namespace cairn::adjustment
