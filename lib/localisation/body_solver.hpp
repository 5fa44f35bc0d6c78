// One body from the boxes of one target: least squares on the sides of the boxes.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "localisation/body_model.hpp"
#include "localisation/view.hpp"

namespace cairn::localisation {

// Left, top, right, bottom side of a box, as the plane through the camera centre and that line of the ideal image.
// normal.(p - camera) = depth of p times (pixel of p - pixel of the side), so a body touches the plane where
// normal.(c - camera) + sign h(normal) = 0; that divided by the depth of c is the residual in pixels. To first order
// it is the difference between the outline of the body (for e = 2 the conic P Q* P^T) and the side.
struct BoxPlanes {
  geometry::Vec3 camera = geometry::Vec3::Zero();    // relative to the origin of the parameters, m
  geometry::Vec3 forward = geometry::Vec3::UnitZ();  // optical axis, unit
  std::array<geometry::Vec3, 4> normal{};            // world, px
  std::array<bool, 4> used{};                        // false: cut by the border of the image
  // Inverse square root of the sides' covariance; zero rows where not used. 1/px
  Eigen::Matrix4d whitener = Eigen::Matrix4d::Zero();
};

inline constexpr std::array<double, 4> kSideSign{-1.0, -1.0, 1.0, 1.0};

[[nodiscard]] BoxPlanes box_planes(const View& view, const geometry::PixelBox& ideal, const geometry::Vec3& origin);

using BodyParameters = std::array<double, kBodyParameters>;
using BodyMatrix = Eigen::Matrix<double, static_cast<int>(kBodyParameters), static_cast<int>(kBodyParameters)>;
using SideJacobian = Eigen::Matrix<double, 4, static_cast<int>(kBodyParameters), Eigen::RowMajor>;

// A normal prior on each parameter; sigma 0 = none, negative = held fixed at the mean.
struct BodyPrior {
  BodyParameters mean{}, sigma{};
  // The half height is judged against the mean level semi-axis: mean and sigma of kLogHalfHeight are of t - p.
};

// Residuals of the four sides [px], not whitened; 0 where a side is not used. False where the body's
// centre is not in front of the camera.
[[nodiscard]] bool side_residuals(const BoxPlanes& box, const BodyParameters& x, Eigen::Vector4d* residual,
                                  SideJacobian* jacobian);

struct BodySolution {
  BodyParameters x{};
  std::string failure;                    // reason code; empty = solved
  BodyMatrix normal;                      // sum of w J^T J (whitened) and the priors
  std::vector<double> weight;             // w of each box by the robust loss, 0..1
  std::vector<Eigen::Vector4d> residual;  // of each box, not whitened, px
  std::vector<SideJacobian> jacobian;     // of these
  int iterations = 0;
};

// Levenberg-Marquardt (Ceres, automatic derivatives, one thread) with Cauchy's loss on each box's whitened
// residual; `scale` = the norm at which a box has half its weight. Failures: fit_behind_camera, fit_not_converged,
// fit_singular. Cost: linear in boxes, about 20 us a box.
[[nodiscard]] BodySolution solve_body(std::span<const BoxPlanes> boxes, const BodyParameters& start,
                                      const BodyPrior& prior, double scale);

}  // namespace cairn::localisation
