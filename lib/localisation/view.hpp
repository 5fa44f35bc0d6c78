// An image as an ideal pinhole camera: what the points filter projects through.
#pragma once

#include <optional>

#include "geometry/primitives.hpp"
#include "geometry/rigid_transform.hpp"
#include "survey/camera.hpp"

namespace cairn::localisation {

// Distortion is taken out of the boxes once (undistorted below), so that projecting thousands of
// points costs two divisions each. Pixels of this view are ideal: u = fx x/z + cx.
struct View {
  geometry::RigidTransform T_world_camera;
  double fx_px = 1.0, fy_px = 1.0, cx_px = 0.0, cy_px = 0.0;

  [[nodiscard]] geometry::Vec3 to_camera(const geometry::Vec3& p_world) const {
    return T_world_camera.rotation.transpose() * (p_world - T_world_camera.translation);
  }
  // Empty behind the camera.
  [[nodiscard]] std::optional<geometry::Vec2> project(const geometry::Vec3& p_world) const;
  // d pixel / d p_world at a point with camera coordinates p_camera, z > 0.
  [[nodiscard]] Eigen::Matrix<double, 2, 3> jacobian(const geometry::Vec3& p_camera) const;
  // Direction through an ideal pixel, world, z component 1 in the camera (so that depth scales it).
  [[nodiscard]] geometry::Vec3 direction(const geometry::Vec2& pixel) const;
};

[[nodiscard]] View ideal_view(const survey::Camera& camera, const geometry::RigidTransform& T_world_camera);

// An ideal pixel for a raw one. Empty where the distortion cannot be inverted, or more than 80 deg
// off the axis (there a pinhole's pixels mean nothing).
[[nodiscard]] std::optional<geometry::Vec2> undistorted(const survey::Camera& camera, const geometry::Vec2& pixel);

// The axis-aligned ideal box of a raw box: each side is the mean of three undistorted points of it.
[[nodiscard]] std::optional<geometry::PixelBox> undistorted(const survey::Camera& camera,
                                                            const geometry::PixelBox& box);

}  // namespace cairn::localisation
