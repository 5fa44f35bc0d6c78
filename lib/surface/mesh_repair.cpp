#include "surface/mesh_repair.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <unordered_map>

#include "geometry/mass_properties.hpp"

namespace cairn::surface {
namespace {

using geometry::Triangle;
using geometry::TriangleMesh;
using geometry::Vec2;
using geometry::Vec3;

using Loop = std::vector<std::uint32_t>;

std::uint64_t key(std::uint32_t a, std::uint32_t b) {
  return (static_cast<std::uint64_t>(a) << 32U) | b;
}

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Directed edges and the triangles that use them, in order of triangle.
std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> edge_users(const TriangleMesh& mesh) {
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> users;
  users.reserve(3 * mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) users[key(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3])].push_back(t);
  return users;
}

// Turns faces so that neighbours across an edge of two faces agree; each piece follows its majority.
bool turn_to_agree(TriangleMesh& mesh) {
  const auto users = edge_users(mesh);
  const auto of = [&](std::uint32_t a, std::uint32_t b) -> const std::vector<std::uint32_t>* {
    const auto found = users.find(key(a, b));
    return found == users.end() ? nullptr : &found->second;
  };
  enum : signed char { unknown = 0, kept = 1, turned = -1 };
  std::vector<signed char> state(mesh.triangles.size(), unknown);
  bool changed = false;
  for (std::uint32_t seed = 0; seed < mesh.triangles.size(); ++seed) {
    if (state[seed] != unknown) continue;
    std::vector<std::uint32_t> piece{seed};
    state[seed] = kept;
    std::size_t turns = 0;
    for (std::size_t i = 0; i < piece.size(); ++i) {
      const auto t = piece[i];
      for (std::size_t k = 0; k < 3; ++k) {
        const auto a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
        const auto *same = of(a, b), *opposite = of(b, a);
        const std::size_t count = (same ? same->size() : 0) + (opposite ? opposite->size() : 0);
        if (count != 2) continue;
        const bool agrees = opposite != nullptr;
        const auto other = agrees ? opposite->front() : (same->front() == t ? same->back() : same->front());
        if (state[other] != unknown) continue;
        state[other] = agrees ? state[t] : static_cast<signed char>(-state[t]);
        if (state[other] == turned) ++turns;
        piece.push_back(other);
      }
    }
    const bool flip_others = 2 * turns > piece.size();
    for (const auto t : piece) {
      const bool flip = flip_others ? state[t] == kept : state[t] == turned;
      if (!flip) continue;
      std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
      changed = true;
    }
  }
  return changed;
}

// Keeps the first face on each directed edge.
bool remove_folds(TriangleMesh& mesh) {
  std::set<std::uint64_t> used;
  std::vector<Triangle> kept;
  for (const auto& t : mesh.triangles) {
    const std::array<std::uint64_t, 3> edges{key(t[0], t[1]), key(t[1], t[2]), key(t[2], t[0])};
    if (std::any_of(edges.begin(), edges.end(), [&](std::uint64_t e) { return used.count(e) > 0; })) continue;
    used.insert(edges.begin(), edges.end());
    kept.push_back(t);
  }
  const bool changed = kept.size() != mesh.triangles.size();
  mesh.triangles = std::move(kept);
  return changed;
}

bool drop_small_pieces(TriangleMesh& mesh) {
  std::vector<std::uint32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root = [&parent](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 1; k < 3; ++k) {
      const auto a = root(t[0]), b = root(t[k]);
      parent[std::max(a, b)] = std::min(a, b);
    }
  std::map<std::uint32_t, double> areas;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    areas[root(mesh.triangles[t][0])] += mesh.area_vector(t).norm();
  double largest = 0.0;
  for (const auto& [piece, area] : areas) largest = std::max(largest, area);
  constexpr double kLeastShare = 0.05;
  const auto before = mesh.triangles.size();
  std::erase_if(mesh.triangles, [&](const Triangle& t) { return areas[root(t[0])] < kLeastShare * largest; });
  return mesh.triangles.size() != before;
}

std::set<std::uint64_t> directed_edges(const TriangleMesh& mesh) {
  std::set<std::uint64_t> edges;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) edges.insert(key(t[k], t[(k + 1) % 3]));
  return edges;
}

// Rims of the holes, in the sense of the faces that close them; a vertex touched twice ends a loop.
std::vector<Loop> hole_rims(const TriangleMesh& mesh) {
  const auto edges = directed_edges(mesh);
  std::map<std::uint32_t, std::vector<std::uint32_t>> next;
  for (const auto e : edges) {
    const auto a = static_cast<std::uint32_t>(e >> 32U), b = static_cast<std::uint32_t>(e & 0xffffffffU);
    if (edges.count(key(b, a)) == 0) next[b].push_back(a);
  }
  std::vector<Loop> loops;
  for (auto& [start, ways] : next)
    while (!ways.empty()) {
      Loop path{start};
      while (true) {
        auto& onward = next[path.back()];
        if (onward.empty()) break;  // cannot close: an edge of more faces than two
        const auto to = onward.back();
        onward.pop_back();
        const auto met = std::find(path.begin(), path.end(), to);
        if (met == path.end()) {
          path.push_back(to);
          continue;
        }
        loops.emplace_back(met, path.end());
        path.erase(met + 1, path.end());
        if (path.size() == 1 && next[path.back()].empty()) break;
      }
    }
  return loops;
}

struct FlatRim {
  Vec3 middle = Vec3::Zero(), normal = Vec3::UnitZ();
  std::vector<Vec2> points;  // counter-clockwise about `normal`
  double roughness = 0.0;
};

FlatRim flatten(const TriangleMesh& mesh, const Loop& loop) {
  FlatRim rim;
  double length = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec3 &a = mesh.vertices[loop[i]], &b = mesh.vertices[loop[(i + 1) % loop.size()]];
    rim.middle += (b - a).norm() * 0.5 * (a + b);
    length += (b - a).norm();
  }
  rim.middle /= length;
  Vec3 area = Vec3::Zero();
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec3 a = mesh.vertices[loop[i]] - rim.middle, b = mesh.vertices[loop[(i + 1) % loop.size()]] - rim.middle;
    area += Vec3(a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(), a.x() * b.y() - a.y() * b.x());
  }
  if (area.norm() > 0.0) rim.normal = area.normalized();
  const Vec3 aside = std::abs(rim.normal.x()) < 0.9 ? Vec3(Vec3::UnitX()) : Vec3(Vec3::UnitY());
  const Vec3 u = (aside - aside.dot(rim.normal) * rim.normal).normalized();
  const Vec3 n = rim.normal;
  const Vec3 v(n.y() * u.z() - n.z() * u.y(), n.z() * u.x() - n.x() * u.z(), n.x() * u.y() - n.y() * u.x());
  double square = 0.0;
  for (const auto i : loop) {
    const Vec3 p = mesh.vertices[i] - rim.middle;
    rim.points.emplace_back(p.dot(u), p.dot(v));
    square += std::pow(p.dot(n), 2);
  }
  rim.roughness = std::sqrt(square / static_cast<double>(loop.size()));
  return rim;
}

// Ears of a simple polygon; empty where none is left to cut. No chord may run along an edge of the mesh: that edge
// would have more than two faces.
std::vector<Triangle> ears(const FlatRim& rim, const Loop& loop, const std::set<std::uint64_t>& edges) {
  std::vector<std::size_t> left(loop.size());
  std::iota(left.begin(), left.end(), std::size_t{0});
  std::vector<Triangle> result;
  while (left.size() > 3) {
    std::size_t best = left.size();
    double least = 1e300;
    for (std::size_t i = 0; i < left.size(); ++i) {
      const auto ia = left[(i + left.size() - 1) % left.size()], ib = left[i], ic = left[(i + 1) % left.size()];
      const Vec2 &a = rim.points[ia], &b = rim.points[ib], &c = rim.points[ic];
      if (!(cross(b - a, c - a) > 0.0)) continue;
      const double length = (c - a).squaredNorm();
      if (length >= least || edges.count(key(loop[ia], loop[ic])) > 0 || edges.count(key(loop[ic], loop[ia])) > 0)
        continue;
      const bool holds = std::any_of(left.begin(), left.end(), [&](std::size_t j) {
        if (j == ia || j == ib || j == ic) return false;
        const Vec2& p = rim.points[j];
        return cross(b - a, p - a) >= 0.0 && cross(c - b, p - b) >= 0.0 && cross(a - c, p - c) >= 0.0;
      });
      if (holds) continue;
      best = i;
      least = length;
    }
    if (best == left.size()) return {};
    const auto before = (best + left.size() - 1) % left.size(), after = (best + 1) % left.size();
    result.push_back({loop[left[before]], loop[left[best]], loop[left[after]]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(best));
  }
  result.push_back({loop[left[0]], loop[left[1]], loop[left[2]]});
  return result;
}

void close_hole(TriangleMesh& mesh, const Loop& loop, const FlatRim& rim, const std::set<std::uint64_t>& edges) {
  if (loop.size() == 3) {
    mesh.triangles.push_back({loop[0], loop[1], loop[2]});
    return;
  }
  bool star = true;
  for (std::size_t i = 0; i < loop.size(); ++i)
    star = star && cross(rim.points[i], rim.points[(i + 1) % loop.size()]) > 0.0;
  constexpr std::size_t kMostForEars = 5000;
  if (!star && loop.size() <= kMostForEars) {
    const auto cut = ears(rim, loop, edges);
    if (!cut.empty()) {
      mesh.triangles.insert(mesh.triangles.end(), cut.begin(), cut.end());
      return;
    }
  }
  const auto centre = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.push_back(rim.middle);
  for (std::size_t i = 0; i < loop.size(); ++i)
    mesh.triangles.push_back({centre, loop[i], loop[(i + 1) % loop.size()]});
}

bool is_base(const TriangleMesh& mesh, const FlatRim& rim) {
  constexpr double kSteepest = 0.5;  // cosine
  return rim.normal.z() < -kSteepest && rim.middle.z() < mesh.bounds().centre().z();
}

}  // namespace

RepairedMesh repair(const TriangleMesh& given) {
  RepairedMesh result;
  auto& mesh = result.mesh;
  std::size_t degenerate = 0;
  for (std::size_t t = 0; t < given.triangles.size(); ++t)
    if (given.area_vector(t).squaredNorm() == 0.0) ++degenerate;
  mesh = geometry::weld(given);
  mesh.colours.clear();
  if (mesh.vertices.size() < given.vertices.size()) result.notes.emplace_back("unwelded");
  if (degenerate > 0) result.notes.emplace_back("degenerate_triangles");
  if (mesh.triangles.empty()) return result;
  if (turn_to_agree(mesh)) result.notes.emplace_back("faces_turned");
  if (remove_folds(mesh)) result.notes.emplace_back("folds_removed");
  if (drop_small_pieces(mesh)) result.notes.emplace_back("pieces_dropped");
  if (geometry::mass_properties(mesh).volume < 0.0) {
    mesh = geometry::flipped(mesh);
    result.notes.emplace_back("turned_outwards");
  }
  result.made.assign(mesh.triangles.size(), 0);
  const auto rims = hole_rims(mesh);
  std::vector<FlatRim> flat;
  std::vector<double> areas;
  for (const auto& loop : rims) {
    flat.push_back(flatten(mesh, loop));
    double twice = 0.0;
    for (std::size_t i = 0; i < loop.size(); ++i)
      twice += cross(flat.back().points[i], flat.back().points[(i + 1) % loop.size()]);
    areas.push_back(0.5 * std::abs(twice));
  }
  const auto largest = static_cast<std::size_t>(std::max_element(areas.begin(), areas.end()) - areas.begin());
  const bool base = !rims.empty() && is_base(mesh, flat[largest]);
  if (base) {
    result.base_roughness = flat[largest].roughness;
    for (const auto v : rims[largest]) {
      survey::ContactVertex vertex;
      vertex.order = static_cast<std::int64_t>(result.base.size());
      vertex.position = mesh.vertices[v];
      result.base.push_back(vertex);
    }
  }
  const auto edges = directed_edges(mesh);
  for (std::size_t i = 0; i < rims.size(); ++i) close_hole(mesh, rims[i], flat[i], edges);
  if (rims.size() > (base ? 1U : 0U)) result.notes.emplace_back("holes_closed");
  if (base) result.notes.emplace_back("base_closed");
  result.made.resize(mesh.triangles.size(), 1);
  double made = 0.0, whole = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double area = mesh.area_vector(t).norm();
    whole += area;
    if (result.made[t] != 0) made += area;
  }
  result.closed_share = whole > 0.0 ? made / whole : 0.0;
  double holes = 0.0;
  for (std::size_t i = 0; i < rims.size(); ++i)
    if (!base || i != largest) holes += areas[i];
  result.hole_share = whole > 0.0 ? holes / whole : 0.0;
  return result;
}

}  // namespace cairn::surface
