// The ground that an image shows, as a simple polygon.
#pragma once

#include "geometry/primitives.hpp"
#include "geometry/rigid_transform.hpp"
#include "ground/ground_height.hpp"
#include "survey/camera.hpp"

namespace cairn::ground {

// No two sides that are not neighbours touch or cross. Fewer than 3 vertices: false. Cost n^2.
[[nodiscard]] bool is_simple(const geometry::Ring& ring);

// Outline of the image on the ground [local east, north, m], counter-clockwise, always simple; empty where it shows no
// ground within max_range [m, level] of the camera. `per_side` border pixels a side are cast onto the terrain. Where
// one of them looks too flat or too far, or the outline crosses itself (a ridge hides ground), it is instead the
// ground plane below the middle of the image within the image's four corner rays and within max_range: both convex,
// so no bow-tie can come of a horizon in the image.
[[nodiscard]] geometry::Ring image_footprint(const survey::Camera& camera,
                                             const geometry::RigidTransform& T_world_camera, const Ground& ground,
                                             double max_range = 150.0, double step = 0.25, int per_side = 6);

// Distance of a point inside the ring to its border [m]; negative outside.
[[nodiscard]] double depth_inside(const geometry::Ring& ring, const geometry::Vec2& p);

}  // namespace cairn::ground
