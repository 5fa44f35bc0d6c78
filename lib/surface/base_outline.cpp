#include "surface/base_outline.hpp"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "surface/triangulation.hpp"

namespace cairn::surface {

using geometry::Vec2;
using geometry::Vec3;

survey::Contact foot_outline(std::span<const Vec3> points, const std::function<double(const Vec2&)>& ground,
                             double spacing) {
  survey::Contact contact;
  double lowest = 1e300, highest = -1e300;
  for (const auto& p : points) {
    const double up = p.z() - ground(p.head<2>());
    lowest = std::min(lowest, up);
    highest = std::max(highest, up);
  }
  constexpr double kBand = 3.0, kNear = 6.0, kNearShare = 0.1;
  const bool on_ground = lowest <= std::max(kNear * spacing, kNearShare * (highest - lowest));
  std::vector<Vec2> foot;
  const Vec2 origin = points.front().head<2>();
  for (const auto& p : points)
    if (p.z() - ground(p.head<2>()) <= lowest + kBand * spacing) foot.push_back(p.head<2>() - origin);
  constexpr double kLongestEdge = 16.0;
  const auto triangles = trim_rim(foot, delaunay(foot), kLongestEdge * spacing);
  // The rim is one simple ring: sides that no other triangle runs the other way.
  std::map<std::uint32_t, std::uint32_t> next;
  std::map<std::pair<std::uint32_t, std::uint32_t>, bool> sides;
  for (const auto& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) sides[{t[k], t[(k + 1) % 3]}] = true;
  for (const auto& [side, present] : sides)
    if (sides.find({side.second, side.first}) == sides.end()) next[side.first] = side.second;
  if (next.empty()) return contact;
  const auto start = next.begin()->first;
  std::int64_t order = 0;
  for (auto v = start; order <= static_cast<std::int64_t>(next.size());) {
    survey::ContactVertex vertex;
    const Vec2 q = foot[v] + origin;
    vertex.order = order++;
    vertex.position = {q.x(), q.y(), ground(q) + (on_ground ? 0.0 : lowest)};
    vertex.sigma_m = kBand * spacing;
    contact.push_back(vertex);
    v = next.at(v);
    if (v == start) break;
  }
  return contact;
}

}  // namespace cairn::surface
