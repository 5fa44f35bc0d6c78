// What readers of clouds and meshes return: the data, and what the file told about them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "geometry/point_cloud.hpp"
#include "geometry/triangle_mesh.hpp"

namespace cairn::io {

struct SourceFacts {
  std::string format;   // "LAS", "PLY", "PCD", "OBJ", "XYZ", "STL", "GLB", ...
  std::string version;  // of the format, with its flavour: "1.2, point format 3", "1.0, ascii"
  std::string crs;      // "EPSG:32615", WKT, or "" where the file declares none
  // Length of a unit as the file states it beside the CRS [m]; 0 = not stated. Where it contradicts the
  // CRS, nobody knows the unit: that is an error of the file.
  double horizontal_unit_m = 0.0, vertical_unit_m = 0.0;
  std::vector<std::string> comments;
  std::uint64_t declared_points = 0;  // points or vertices in the file
  std::uint64_t declared_faces = 0;   // polygons in the file, before they are cut into triangles
  std::uint64_t dropped_points = 0;   // with a coordinate that is not finite
  std::uint64_t dropped_faces = 0;    // with a dropped vertex, or fewer than three vertices
  std::vector<std::string> warnings;  // sentences for people
};

// Coordinates are in the file's own system and units, in double.
struct CloudData {
  geometry::PointCloud cloud;
  SourceFacts facts;
};

struct MeshData {
  geometry::TriangleMesh mesh;
  SourceFacts facts;
};

// Value that stands for a scalar that is not finite.
inline constexpr double kNoDataValue = -9999.0;

// Drops points with a coordinate that is not finite, and says so in the facts. Scalars that are
// not finite become kNoDataValue, GPS times 0; normals are scaled to unit length, or zeroed.
void drop_non_finite(CloudData& data);

// Drops vertices with a coordinate that is not finite and the triangles that use them.
void drop_non_finite(MeshData& data);

}  // namespace cairn::io
