// The front door for triangle meshes: any format, recognised by its content.
#pragma once

#include <filesystem>
#include <string>

#include "io/glb.hpp"
#include "io/source_facts.hpp"

namespace cairn::io {

enum class MeshFormat { ply, obj, stl, glb, gltf, dae, off };

// By the first bytes, else by the extension. Throws invalid_input with the formats that are read.
[[nodiscard]] MeshFormat recognise_mesh(const std::filesystem::path& path);

// z-up, in the file's units. OBJ and PLY in double by our own readers; the others through assimp
// in single precision (see io/assimp_mesh.hpp).
[[nodiscard]] MeshData read_mesh(const std::filesystem::path& path);

// By the extension of `path`: .ply, .obj or .glb; glb options apply to .glb alone. Writes straight to `path`.
void write_mesh(const std::filesystem::path& path, const geometry::TriangleMesh& mesh, const GlbWriteOptions& glb = {});

}  // namespace cairn::io
