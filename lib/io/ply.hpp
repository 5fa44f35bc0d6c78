// PLY clouds and meshes, by our own reader (double precision throughout) and writer.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/source_facts.hpp"

namespace cairn::io {

// ascii, binary_little_endian and binary_big_endian 1.0. Properties of `vertex`, any type:
// x y z; nx ny nz; red green blue (r g b, diffuse_*), 8 bits scaled to 16; intensity (integer),
// classification (uchar), gps_time; every other scalar becomes a column under its name, lists are
// skipped. A comment line "crs EPSG:n" (or WKT) declares the CRS. Other elements are skipped.
// Throws invalid_input with the byte or line.
[[nodiscard]] CloudData read_ply_cloud(const std::filesystem::path& path);

// Vertices and the polygons of `face` (vertex_indices or vertex_index, any list type), cut into
// triangles as fans. A file without faces gives a mesh without triangles.
[[nodiscard]] MeshData read_ply_mesh(const std::filesystem::path& path);

struct PlyWriteOptions {
  std::string crs;                    // written as a comment; "" = none
  std::vector<std::string> comments;  // one line each
};

// binary_little_endian, positions in double, normals in float, colours with 8 bits; scalars keep
// their type (64-bit integers become double). Throws invalid_argument where a coordinate is
// not finite; scalars that are not finite become -9999.
void write_ply(const std::filesystem::path& path, const geometry::PointCloud& cloud,
               const PlyWriteOptions& options = {});
void write_ply(const std::filesystem::path& path, const geometry::TriangleMesh& mesh,
               const PlyWriteOptions& options = {});

}  // namespace cairn::io
