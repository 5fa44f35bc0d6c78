// The 3-D points that stand for a target's position: generation, update, Gaussian.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>

#include "base/random.hpp"
#include "geometry/primitives.hpp"
#include "geometry/vec.hpp"
#include "localisation/view.hpp"

namespace cairn::localisation {

// m x 3, one point a row, local ENU, m. Each coordinate is contiguous.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3>;

// Depth along camera z, m; 0 <= near < far.
struct DepthRange {
  double near_m = 0.0, far_m = 0.0;
};

// How a box is filled.
//   corner_weights: paper A's Algorithm 1, four uniform weights scaled to sum 1. Crowds the centre:
//     standard deviation 0.1614 of the side, the central quarter holds 75.9 % of the points.
//   uniform: 0.2887 and 25 %.
enum class BoxFill { corner_weights, uniform };

// Paper A, Algorithm 1: `count` points in the cone over an (already enlarged) ideal box, depth
// uniform in range. Cost linear.
[[nodiscard]] Points generate_points(const View& view, const geometry::PixelBox& box, std::size_t count,
                                     const DepthRange& range, BoxFill fill, base::Random& random);

struct UpdateOptions {
  double noise_m = 0.1;          // 1 sigma, each axis
  double gaussian_weight = 0.2;  // w1 of (A.3)
  double uniform_weight = 0.8;   // w2 of (A.3)
  bool move_points = true;       // resample the noised points; false = Algorithm 2's letter: weight the noised,
                                 //   draw the un-noised, so that no point ever moves
  bool cheirality = true;        // points behind the camera weigh 0; false = they count where they project to
  bool systematic = true;        // low-variance resampling; false = independent draws
};

struct UpdateReport {
  bool updated = false;         // false: all weights were 0 (or the box empty), the points are as before
  std::size_t behind = 0;       // points behind the camera
  double effective_points = 0;  // (sum w)^2 / sum w^2
};

// Paper A, Algorithm 2 with the misprints corrected: noise, weights (A.3), resampling.
// The box is ideal (undistorted) and not enlarged. Cost linear in points (independent draws: m log m).
UpdateReport update_points(Points& points, const View& view, const geometry::PixelBox& box,
                           const UpdateOptions& options, base::Random& random);

struct Gaussian {
  geometry::Vec3 mean = geometry::Vec3::Zero();        // m
  geometry::Mat3 covariance = geometry::Mat3::Zero();  // m^2
};

// Mean and sample covariance (divisor m - 1; zero for one point). Precondition: at least one point.
[[nodiscard]] Gaussian fit_gaussian(const Points& points);

// (A.4), nats, by Cholesky. Empty where the covariance is singular or not finite.
[[nodiscard]] std::optional<double> differential_entropy(const geometry::Mat3& covariance);

// (A.5), D(updated || previous), >= 0. Empty where either covariance is singular.
[[nodiscard]] std::optional<double> divergence(const Gaussian& updated, const Gaussian& previous);

}  // namespace cairn::localisation
