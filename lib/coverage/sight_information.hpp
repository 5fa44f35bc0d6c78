// What one sight line tells about the position of the point it meets, errors of pixel and pose taken together.
#pragma once

#include <array>

#include "coverage/view.hpp"
#include "geometry/vec.hpp"

namespace cairn::coverage {

// Error model of one view: independent between views, and between the parts of one.
struct ViewNoise {
  float pixel_px2 = 0.25F;     // variance of an image measurement along x and y
  float xy_m2 = 0.0F;          // of the camera's position, east and north
  float z_m2 = 0.0F;           // up
  float rotation_rad2 = 0.0F;  // of its attitude about each axis
};

// Standard deviations of a view's pose; those it does not state (0) are taken from here.
struct NoiseOptions {
  double pixel_sigma_px = 0.5;       // of a matched image point, along x and y
  double position_sigma_m = 0.02;    // of a camera's position where the frame does not state it
  double rotation_sigma_deg = 0.01;  // of a camera's attitude where the frame does not state it
};

[[nodiscard]] ViewNoise view_noise(const View& view, const NoiseOptions& options);

// Standard deviations of the point where all these sight lines meet.
struct PointSigma {
  double largest_m = 0.0;  // along the direction known worst
  double up_m = 0.0;
};

// The upper triangle xx, xy, xz, yy, yz, zz of an information matrix [1/m^2], world axes.
using Information = std::array<double, 6>;

// Least squares over all sight lines, each weighted by its own errors: covariance = inverse of the summed information
//   J^T (s_px^2 I + J (S_position + s_rot^2 r^2 I) J^T)^-1 J,   J = d pixel / d point (2 x 3), r = range.
// First order; errors common to all views (a shifted survey) are not in it. NaN where the lines do not fix the point.
// Cost: constant.
[[nodiscard]] PointSigma point_sigma(const Information& information);

}  // namespace cairn::coverage
