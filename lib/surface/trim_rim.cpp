#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "surface/triangulation.hpp"

namespace cairn::surface {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;  // low, high

Edge edge(std::uint32_t a, std::uint32_t b) {
  return {std::min(a, b), std::max(a, b)};
}

}  // namespace

std::vector<geometry::Triangle> trim_rim(std::span<const geometry::Vec2> points,
                                         std::vector<geometry::Triangle> triangles, double max_edge) {
  std::map<Edge, std::vector<std::size_t>> users;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) users[edge(triangles[t][k], triangles[t][(k + 1) % 3])].push_back(t);

  std::vector<char> on_rim(points.size(), 0);
  // Longest first; ties by the vertices, so the order is total.
  std::set<std::tuple<double, std::uint32_t, std::uint32_t>, std::greater<>> rim;
  const auto add_rim = [&](const Edge& e) {
    on_rim[e.first] = on_rim[e.second] = 1;
    const double length = (points[e.first] - points[e.second]).norm();
    if (length > max_edge) rim.emplace(length, e.first, e.second);
  };
  for (const auto& [e, used_by] : users)
    if (used_by.size() == 1) add_rim(e);

  std::vector<char> removed(triangles.size(), 0);
  while (!rim.empty()) {
    const auto [length, a, b] = *rim.begin();
    rim.erase(rim.begin());
    const std::size_t t = users[{a, b}].front();
    std::uint32_t tip = 0;
    for (const std::uint32_t v : triangles[t])
      if (v != a && v != b) tip = v;
    // A tip that lies on the rim already would pinch the outline, or leave a point out.
    if (on_rim[tip] != 0) continue;
    removed[t] = 1;
    for (const Edge& e : {edge(a, tip), edge(b, tip)}) {
      auto& used_by = users[e];
      std::erase(used_by, t);
      add_rim(e);
    }
  }
  std::vector<geometry::Triangle> kept;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (removed[t] == 0) kept.push_back(triangles[t]);
  return kept;
}

}  // namespace cairn::surface
