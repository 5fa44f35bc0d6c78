// Wavefront OBJ meshes, by our own reader in double precision.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/source_facts.hpp"

namespace cairn::io {

// v (with an optional weight, or colours), f in all four forms with positive and negative indices,
// polygons cut into triangles as fans, lines continued by a backslash. Normals and texture
// coordinates are skipped; groups and objects are joined. Material libraries are never opened.
// Throws invalid_input with the line.
[[nodiscard]] MeshData read_obj_mesh(const std::filesystem::path& path);

// The vertices alone.
[[nodiscard]] CloudData read_obj_cloud(const std::filesystem::path& path);

struct ObjWriteOptions {
  std::vector<std::string> comments;  // lines at the head of the file
};

// Coordinates in shortest round-trip form, colours (where there are any) behind them as three numbers 0..1.
// Throws invalid_argument where a coordinate is not finite.
void write_obj(const std::filesystem::path& path, const geometry::TriangleMesh& mesh,
               const ObjWriteOptions& options = {});

}  // namespace cairn::io
