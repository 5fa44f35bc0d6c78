// STL, GLB, glTF, DAE and OFF meshes, read by assimp.
#pragma once

#include <filesystem>
#include <string_view>

#include "io/source_facts.hpp"

namespace cairn::io {

// hint: "stl", "glb", "gltf", "dae" or "off". Coordinates pass through single precision: a mesh whose
// coordinates are far larger than its size (a projected CRS) loses millimetres to decimetres,
// and a warning says how much. GLB, glTF and DAE are y-up and come back z-up (x, -z, y); in a GLB file of
// ours the origin in `extras` is added again in double. STL and OFF are taken as they
// are; identical corners of STL are joined. Node transforms are applied. Files that the mesh refers
// to (buffers, textures) are never opened. At most 1 GiB. Throws invalid_input.
[[nodiscard]] MeshData read_assimp_mesh(const std::filesystem::path& path, std::string_view hint);

}  // namespace cairn::io
