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
// normal.(c - camera) + sign h(sign normal) = 0; that divided by the depth of c is the residual in pixels. To first
// order it is the difference between the outline of the body (of an ellipsoid: the conic P Q* P^T) and the side.
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

inline constexpr std::size_t kBodyParameters = kEllipsoidParameters + kHarmonics;  // in this order
using BodyVector = Eigen::Matrix<double, static_cast<int>(kBodyParameters), 1>;
using BodyMatrix = Eigen::Matrix<double, static_cast<int>(kBodyParameters), static_cast<int>(kBodyParameters)>;
using SideJacobian = Eigen::Matrix<double, 4, static_cast<int>(kBodyParameters), Eigen::RowMajor>;

// Normal priors. Of the ellipsoid: independent, sigma 0 = none; that of kLogHalfHeight is on t - p, the half height
// against the mean level semi-axis. Of the harmonics: mean and inverse covariance.
struct BodyPrior {
  Eigen::Matrix<double, static_cast<int>(kEllipsoidParameters), 1> mean, sigma;
  Eigen::Matrix<double, static_cast<int>(kHarmonics), 1> harmonic_mean;
  Eigen::Matrix<double, static_cast<int>(kHarmonics), static_cast<int>(kHarmonics)> harmonic_information;

  BodyPrior() {
    mean.setZero();
    sigma.setZero();
    harmonic_mean.setZero();
    harmonic_information.setZero();
  }
};

// Residuals of the four sides [px], not whitened; 0 where a side is not used. False where the body's
// centre is not in front of the camera.
[[nodiscard]] bool side_residuals(const BoxPlanes& box, const Body& body, Eigen::Vector4d* residual,
                                  SideJacobian* jacobian);

struct BodySolution {
  Body body;
  std::string failure;                     // reason code; empty = solved
  BodyMatrix normal = BodyMatrix::Zero();  // sum of w J^T J (whitened) and of the priors
  std::vector<double> weight;              // w of each box by the robust loss, 0..1
  std::vector<Eigen::Vector4d> residual;   // of each box, not whitened, px
  std::vector<SideJacobian> jacobian;      // of these
  int iterations = 0;
};

// First the ellipsoid: Levenberg-Marquardt (Ceres, automatic derivatives, one thread) with Cauchy's loss on each box's
// whitened residual; `scale` = the norm at which a box has half its weight. Then ellipsoid and harmonics together by
// Gauss-Newton with the weights of the same loss. Failures: fit_behind_camera, fit_not_converged, fit_singular.
// Cost: linear in boxes.
[[nodiscard]] BodySolution solve_body(std::span<const BoxPlanes> boxes, const Body& start, const BodyPrior& prior,
                                      double scale);

}  // namespace cairn::localisation
