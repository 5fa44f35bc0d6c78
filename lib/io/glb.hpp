// Binary glTF 2.0 (GLB), written by ourselves. Source: Khronos, glTF 2.0 specification.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>

#include "geometry/triangle_mesh.hpp"
#include "geometry/vec.hpp"
#include "io/json.hpp"

namespace cairn::io {

struct GlbWriteOptions {
  std::string name = "mesh";
  // Subtracted before positions become float, and written as `extras.origin_m` of the scene and
  // of the node. Choose a point near the mesh: float keeps 1e-7 of the distance from it.
  geometry::Vec3 origin = geometry::Vec3::Zero();
  // One sentence on the frame of `origin`, written as extras.frame.
  std::string frame = "local ENU [m]: x east, y north, z up";
  // Further members of extras; an object or null. Must not hold origin_m or frame.
  Json properties;
  // Colour of the surface where the mesh has no colours, linear 0..1.
  std::array<double, 3> base_colour{0.62, 0.55, 0.46};
  // Smooth vertex normals (weighted by angle); false: none, viewers shade flat.
  bool normals = true;
};

// One node, one double-sided mesh with POSITION, NORMAL and COLOR_0 (sRGB turned into linear light, 16 bits), indices
// u32. The mesh is z-up; the file is y-up as glTF demands: (x, y, z) is written as (x, z, -y), so that no node
// transform is needed and readers that ignore transforms see the same.
// Throws invalid_argument for an empty mesh or a coordinate that is not finite.
void write_glb(const std::filesystem::path& path, const geometry::TriangleMesh& mesh,
               const GlbWriteOptions& options = {});

// The JSON chunk of a GLB file, parsed. Throws invalid_input with the offset.
[[nodiscard]] Json read_glb_json(const std::filesystem::path& path);

}  // namespace cairn::io
