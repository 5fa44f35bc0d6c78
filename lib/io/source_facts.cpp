#include "io/source_facts.hpp"

#include <cmath>
#include <limits>

namespace cairn::io {

void drop_non_finite(CloudData& data) {
  auto& cloud = data.cloud;
  std::vector<std::size_t> kept;
  std::size_t bad = 0;
  for (const auto& p : cloud.positions)
    if (!p.allFinite()) ++bad;
  if (bad > 0) {
    kept.reserve(cloud.size() - bad);
    for (std::size_t i = 0; i < cloud.size(); ++i)
      if (cloud.positions[i].allFinite()) kept.push_back(i);
    cloud = cloud.subset(kept);
    data.facts.dropped_points += bad;
    data.facts.warnings.push_back(std::to_string(bad) + " points with a coordinate that is not finite were dropped");
  }
  for (auto& column : cloud.scalars) {
    std::size_t replaced = 0;
    for (double& v : column.values)
      if (!std::isfinite(v)) {
        v = kNoDataValue;
        ++replaced;
      }
    if (replaced > 0)
      data.facts.warnings.push_back(std::to_string(replaced) + " values of '" + column.name +
                                    "' were not finite and are -9999 now");
  }
  std::size_t times = 0;
  for (double& t : cloud.gps_time)
    if (!std::isfinite(t)) {
      t = 0.0;
      ++times;
    }
  if (times > 0) data.facts.warnings.push_back(std::to_string(times) + " GPS times were not finite and are 0 now");
  std::size_t normals = 0;
  for (auto& n : cloud.normals) {
    const double length = n.norm();
    if (length > 0.0 && std::isfinite(length)) {
      n /= length;
    } else {
      normals += length == 0.0 ? 0U : 1U;
      n.setZero();
    }
  }
  if (normals > 0) data.facts.warnings.push_back(std::to_string(normals) + " normals were not finite and are 0 now");
}

void drop_non_finite(MeshData& data) {
  auto& mesh = data.mesh;
  constexpr auto kGone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> moved;
  std::size_t bad = 0;
  for (const auto& p : mesh.vertices)
    if (!p.allFinite()) ++bad;
  if (bad == 0) return;
  moved.reserve(mesh.vertices.size());
  const bool coloured = !mesh.colours.empty();
  std::size_t to = 0;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (!mesh.vertices[i].allFinite()) {
      moved.push_back(kGone);
      continue;
    }
    moved.push_back(static_cast<std::uint32_t>(to));
    mesh.vertices[to] = mesh.vertices[i];
    if (coloured) mesh.colours[to] = mesh.colours[i];
    ++to;
  }
  mesh.vertices.resize(to);
  if (coloured) mesh.colours.resize(to);
  const std::size_t before = mesh.triangles.size();
  std::erase_if(mesh.triangles, [&](geometry::Triangle& t) {
    for (auto& v : t) v = moved[v];
    return t[0] == kGone || t[1] == kGone || t[2] == kGone;
  });
  data.facts.dropped_points += bad;
  data.facts.dropped_faces += before - mesh.triangles.size();
  data.facts.warnings.push_back(std::to_string(bad) +
                                " vertices with a coordinate that is not finite were dropped, and " +
                                std::to_string(before - mesh.triangles.size()) + " triangles that use them");
}

}  // namespace cairn::io
