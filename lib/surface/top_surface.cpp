#include "surface/top_surface.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "surface/triangulation.hpp"

namespace cairn::surface {
namespace {

using geometry::Triangle;
using geometry::Vec2;
using geometry::Vec3;

// Highest point of each plan position, in order of plan position.
std::vector<Vec3> highest(std::span<const Vec3> points) {
  std::vector<Vec3> sorted(points.begin(), points.end());
  std::sort(sorted.begin(), sorted.end(), [](const Vec3& a, const Vec3& b) {
    if (a.x() != b.x()) return a.x() < b.x();
    if (a.y() != b.y()) return a.y() < b.y();
    return a.z() > b.z();
  });
  sorted.erase(std::unique(sorted.begin(), sorted.end(),
                           [](const Vec3& a, const Vec3& b) { return a.x() == b.x() && a.y() == b.y(); }),
               sorted.end());
  return sorted;
}

}  // namespace

FlaggedMesh close_top_surface(std::span<const Vec3> points, const std::function<double(const Vec2&)>& ground,
                              double max_edge, double clearance) {
  FlaggedMesh result;
  const auto top = highest(points);
  if (top.size() < 3) return result;
  // Local plan coordinates: lengths and predicates keep their digits at a UTM northing.
  std::vector<Vec2> plan;
  plan.reserve(top.size());
  for (const auto& p : top) plan.push_back((p - top.front()).head<2>());
  const auto triangles = trim_rim(plan, delaunay(plan), max_edge);
  if (triangles.empty()) return result;

  auto& mesh = result.mesh;
  const auto n = static_cast<std::uint32_t>(top.size());
  for (const auto& p : top) mesh.vertices.emplace_back(p.x(), p.y(), std::max(p.z(), ground(p.head<2>()) + clearance));
  for (const auto& p : top) mesh.vertices.emplace_back(p.x(), p.y(), ground(p.head<2>()));
  const auto add = [&](const Triangle& t, bool seen) {
    mesh.triangles.push_back(t);
    result.seen.push_back(seen ? 1 : 0);
  };
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed;
  for (const auto& t : triangles) {
    add(t, true);
    for (std::size_t k = 0; k < 3; ++k) ++directed[{t[k], t[(k + 1) % 3]}];
  }
  for (const auto& [side, count] : directed) {
    const auto [a, b] = side;
    if (directed.count({b, a}) > 0) continue;
    add({b, a, a + n}, false);
    add({b, a + n, b + n}, false);
  }
  for (const auto& t : triangles) add({t[0] + n, t[2] + n, t[1] + n}, false);

  // Vertices that no triangle uses (none with a Delaunay start) would only confuse readers.
  std::vector<std::uint32_t> index(mesh.vertices.size(), 0);
  std::vector<char> used(mesh.vertices.size(), 0);
  for (const auto& t : mesh.triangles)
    for (const auto v : t) used[v] = 1;
  std::vector<Vec3> kept;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (used[v] != 0) {
      index[v] = static_cast<std::uint32_t>(kept.size());
      kept.push_back(mesh.vertices[v]);
    }
  mesh.vertices = std::move(kept);
  for (auto& t : mesh.triangles)
    for (auto& v : t) v = index[v];
  return result;
}

}  // namespace cairn::surface
