// Errors of recorded poses.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/rigid_transform.hpp"
#include "simulation/scene.hpp"

namespace cairn::simulation {

struct NoisyPose {
  geometry::RigidTransform T_world_camera;
  // One sigma of one axis, all parts of the noise added in squares (the walk's grows with the square root of time).
  double sigma_xy_m = 0.0, sigma_z_m = 0.0, sigma_rot_deg = 0.0;
};

// times_s: ascending, one a pose. Rotation errors are small rotation vectors in the camera frame:
// R = R_true exp([e]). Sizes must be equal.
[[nodiscard]] std::vector<NoisyPose> noisy_poses(const PoseNoise& noise, std::uint64_t seed,
                                                 std::span<const double> times_s,
                                                 std::span<const geometry::RigidTransform> poses);

}  // namespace cairn::simulation
