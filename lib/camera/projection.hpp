// Pixel <-> ray for every camera model.
#pragma once

#include <optional>
#include <vector>

#include "geometry/primitives.hpp"
#include "geometry/rigid_transform.hpp"
#include "survey/camera.hpp"

namespace cairn::camera {

// Pixel of a point in the camera frame [m], with distortion; empty when the point lies behind the
// camera (z <= 0), or beyond the angle up to which the distortion polynomial is monotone.
// The pixel may lie outside the image: ask inside_image.
[[nodiscard]] std::optional<geometry::Vec2> project(const survey::Camera& camera, const geometry::Vec3& p_camera);

// Unit direction in the camera frame of a pixel (inverse of project; Newton, error < 1e-9 rad).
// Empty where the distortion cannot be inverted.
[[nodiscard]] std::optional<geometry::Vec3> unproject(const survey::Camera& camera, const geometry::Vec2& pixel);

// The same in the world. T_world_camera maps camera to world.
[[nodiscard]] std::optional<geometry::Vec2> project_world(const survey::Camera& camera,
                                                          const geometry::RigidTransform& T_world_camera,
                                                          const geometry::Vec3& p_world);
[[nodiscard]] std::optional<geometry::Ray> pixel_ray(const survey::Camera& camera,
                                                     const geometry::RigidTransform& T_world_camera,
                                                     const geometry::Vec2& pixel);

// Inside the image, at least `margin` of the width and height away from the border (0 <= margin < 0.5).
[[nodiscard]] bool inside_image(const survey::Camera& camera, const geometry::Vec2& pixel, double margin = 0.0);

// The camera as if its images were resized by `factor` > 0 (0.4 = 4000 px -> 1600 px).
[[nodiscard]] survey::Camera scaled(const survey::Camera& camera, double factor);

// Outline of the image on the horizontal plane at height `up` [m, local ENU], `per_side` points a
// side, counter-clockwise from above, distortion followed. Rays above the horizon, or longer than
// max_range [m], are cut at max_range. Empty when no ray meets the plane.
[[nodiscard]] geometry::Ring footprint(const survey::Camera& camera, const geometry::RigidTransform& T_world_camera,
                                       double up, int per_side = 8, double max_range = 1000.0);

}  // namespace cairn::camera
