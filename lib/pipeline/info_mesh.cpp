// Triangle meshes.
#include <cmath>

#include "geometry/mass_properties.hpp"
#include "geometry/triangle_mesh.hpp"
#include "io/mesh.hpp"
#include "pipeline/info_kinds.hpp"

namespace cairn::pipeline::info {
namespace fs = std::filesystem;
namespace {

using io::Json;

Json topology_json(const geometry::MeshTopology& t) {
  return Json::object({{"closed", t.closed()},
                       {"components", t.components},
                       {"boundary_edges", t.boundary_edges},
                       {"inconsistent_edges", t.inconsistent_edges},
                       {"non_manifold_edges", t.non_manifold_edges},
                       {"degenerate_triangles", t.degenerate_triangles}});
}

Json matrix_json(const geometry::Mat3& m) {
  Json rows = Json::array();
  for (int r = 0; r < 3; ++r) rows.push(Json(geometry::Vec3(m.row(r))));
  return rows;
}

Json from_mesh(const fs::path& path, const io::MeshData& data) {
  std::vector<std::string> warnings = data.facts.warnings;
  Json json = begin(path, "mesh", data.facts.format);
  json.set("version", data.facts.version);
  json.set("vertices", data.mesh.vertices.size());
  json.set("faces", static_cast<std::int64_t>(data.facts.declared_faces));
  json.set("triangles", data.mesh.triangles.size());
  json.set("dropped_vertices", static_cast<std::int64_t>(data.facts.dropped_points));
  json.set("dropped_faces", static_cast<std::int64_t>(data.facts.dropped_faces));
  json.set("crs", crs_json(data.facts.crs, warnings));
  json.set("bounds", to_json(data.mesh.bounds()));
  json.set("colours", !data.mesh.colours.empty());
  if (data.mesh.triangles.empty()) {
    warnings.emplace_back("the mesh has no triangles");
    json.set("warnings", warnings);
    return json;
  }
  const geometry::MeshTopology as_is = geometry::topology(data.mesh);
  json.set("topology", topology_json(as_is));
  // Files that split vertices along seams of texture or normals are open by index, closed by place.
  const geometry::TriangleMesh* solid = &data.mesh;
  geometry::TriangleMesh welded;
  bool closed = as_is.closed();
  if (!closed) {
    welded = geometry::weld(data.mesh);
    const geometry::MeshTopology joined = geometry::topology(welded);
    json.set("topology_welded", topology_json(joined));
    closed = joined.closed();
    if (closed) solid = &welded;
  }
  const geometry::MassProperties mass = geometry::mass_properties(*solid);
  json.set("area_m2", mass.area);
  if (closed) {
    json.set("volume_m3", mass.volume);
    json.set("centre_of_mass_m", Json(mass.centre_of_mass));
    json.set("inertia_per_density_m5", matrix_json(mass.inertia_per_density));
    if (mass.volume < 0.0)
      warnings.emplace_back("the mesh is inside out: its triangles are clockwise seen from outside");
  } else {
    json.set("volume_m3", Json());
    warnings.emplace_back("the mesh is not closed: it has no volume");
  }
  json.set("warnings", warnings);
  return json;
}

}  // namespace

Json describe_mesh(const fs::path& path, const InfoOptions& /*options*/) {
  return from_mesh(path, io::read_mesh(path));
}

Json describe_mesh_or_cloud(const fs::path& path, const InfoOptions& options) {
  const io::MeshData data = io::read_mesh(path);
  return data.facts.declared_faces == 0 ? describe_cloud(path, options) : from_mesh(path, data);
}

}  // namespace cairn::pipeline::info
