// Trajectories as the TUM RGB-D benchmark writes them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "geometry/rigid_transform.hpp"

namespace cairn::io {

struct TumPose {
  std::int64_t time_ns = 0;               // the file's seconds, exactly
  geometry::RigidTransform T_world_body;  // m
};

// Rows `timestamp tx ty tz qx qy qz qw` (seconds, metres, Hamilton, body to world), blank-separated; lines that start
// with '#' are comments. In the order of the file. Throws not_found, or invalid_input with the line: another number of
// columns, a number that is not finite, a quaternion whose norm is not 1 within 1 %, no row at all.
[[nodiscard]] std::vector<TumPose> read_tum(const std::filesystem::path& path);

}  // namespace cairn::io
