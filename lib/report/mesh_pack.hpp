// Rock meshes as compact arrays for the 3-D view.
#pragma once

#include "io/json.hpp"
#include "report/report_data.hpp"

namespace cairn::report {

// Vertex clustering on a cubic grid whose cell is doubled until at most `max_triangles` are left.
// Flags follow their triangles; a mesh that is small enough is returned as it is.
struct FlaggedMesh {
  geometry::TriangleMesh mesh;
  std::vector<std::uint8_t> facet_seen;  // empty or one a triangle
};
[[nodiscard]] FlaggedMesh clustered(const FlaggedMesh& mesh, std::size_t max_triangles);

// {"id", "origin": [e, n, u], "p": f32 positions relative to the origin, "t": u32 indices, "s": u8 seen flags,
//  "c": u8 colours, "contact": [...], "com": [...], "base": up, "critical": [...], "triangles", "of"};
// arrays are little-endian, base64. Members without data are absent.
[[nodiscard]] io::Json packed_rock(const RockView& rock, std::size_t max_triangles);

}  // namespace cairn::report
