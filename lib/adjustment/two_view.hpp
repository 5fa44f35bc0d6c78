// Which matches of two images can belong to one rigid scene, whatever the poses.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "geometry/vec.hpp"

namespace cairn::adjustment {

// Directions of one match in the two cameras' frames, as points on the plane z = 1 (undistorted).
struct RayMatch {
  geometry::Vec2 a = geometry::Vec2::Zero(), b = geometry::Vec2::Zero();
};

// essential: the scene has relief; planar: one homography explains nearly all that an essential matrix explains, so
// that a match must fit both (the homography within a band that leaves room for relief); none: too few agree.
enum class TwoViewModel { none, essential, planar };
[[nodiscard]] std::string_view name_of(TwoViewModel model);

struct TwoViewOptions {
  double epipolar = 0.003;    // distance from the epipolar line, in focal lengths
  double relief = 0.06;       // distance from the homography of a planar scene, in focal lengths
  double planar_share = 0.5;  // homography's inliers (at 2 * epipolar) / essential matrix' inliers
  std::size_t min_inliers = 20;
  double min_inlier_share = 0.5;
};

struct TwoView {
  TwoViewModel model = TwoViewModel::none;
  std::vector<std::uint8_t> inlier;  // one a match; all 0 with TwoViewModel::none
  std::size_t inliers = 0;
  std::size_t essential_inliers = 0, homography_inliers = 0;  // at the tight distances
};

// Essential matrix by five points (Nister 2004) and homography by four, both by RANSAC with a fixed seed. An essential
// matrix lets a wrong match pass along its epipolar line; over ground that is nearly a plane the homography's band
// shuts that door. Intrinsics a few per cent off are absorbed. Cost: 5 to 50 ms a pair.
[[nodiscard]] TwoView verify_two_views(std::span<const RayMatch> matches, const TwoViewOptions& options = {});

}  // namespace cairn::adjustment
