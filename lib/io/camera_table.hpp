// A plain table of pinhole cameras: one row a view, no header.
#pragma once

#include <filesystem>
#include <vector>

#include "geometry/rigid_transform.hpp"
#include "survey/camera.hpp"

namespace cairn::io {

struct TableView {
  survey::Camera camera;
  geometry::RigidTransform T_world_camera;
};

// Columns, separated by blanks: x y z (centre, m), nine of the rotation world -> camera row by row, fx fy cx cy width
// height (px). Blank lines and lines that start with '#' are skipped. Rotations are taken as written where they are
// orthonormal within 1e-6.
// Throws invalid_input with the line.
[[nodiscard]] std::vector<TableView> read_camera_table(const std::filesystem::path& path);

}  // namespace cairn::io
