// Projection with its derivatives, and a camera's intrinsics as a vector: what an adjustment needs.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "geometry/vec.hpp"
#include "survey/camera.hpp"

namespace cairn::camera {

// Which intrinsics an adjustment may change.
//   none:   nothing;
//   focal:  f (fx = f, fy keeps its ratio to fx);
//   distortion: the radial terms alone, f held: where the images cannot tell f from the height of the flight;
//   radial: f and the radial terms of the model (pinhole: f; radial: k1 k2; brown: k1 k2 k3; fisheye: k1 to k4);
//   all:    the same, the principal point, and p1 p2 where the model has them.
enum class IntrinsicsSet { none, focal, distortion, radial, all };

constexpr int kMaxIntrinsics = 8;
using IntrinsicsJacobian = Eigen::Matrix<double, 2, kMaxIntrinsics, Eigen::RowMajor>;
using PointJacobian = Eigen::Matrix<double, 2, 3, Eigen::RowMajor>;

// Number of parameters of a set for a model, 0 to 8, in the order f, cx, cy, k1, k2, k3, k4, p1, p2 (those that are
// in).
[[nodiscard]] int intrinsics_count(survey::CameraModel model, IntrinsicsSet set);
[[nodiscard]] std::vector<double> intrinsics_of(const survey::Camera& camera, IntrinsicsSet set);
// The camera with the values put back. Precondition: values.size() == intrinsics_count.
[[nodiscard]] survey::Camera with_intrinsics(survey::Camera camera, IntrinsicsSet set, std::span<const double> values);

// Pixel of a point in the camera frame [m] as `project` gives it, with its derivatives by the point [px/m] and by
// the set's parameters (the first intrinsics_count columns; nullptr = not wanted). False, and nothing written, where
// z <= 1e-9 m; the fold of the distortion is not looked at (an adjustment passes close by it, not over it).
// Cost: about 60 flops.
[[nodiscard]] bool project_with_jacobian(const survey::Camera& camera, const geometry::Vec3& p_camera,
                                         IntrinsicsSet set, geometry::Vec2& pixel, PointJacobian& by_point,
                                         IntrinsicsJacobian* by_intrinsics);

}  // namespace cairn::camera
