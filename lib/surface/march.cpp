#include "surface/march.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "geometry/mass_properties.hpp"

namespace cairn::surface {
namespace {

using geometry::Triangle;
using geometry::Vec3;

// Corners of a cube by bit: 1 = x, 2 = y, 4 = z. Each tetrahedron climbs from corner 0 to corner 7 along three axes.
constexpr std::array<std::array<int, 4>, 6> kTetrahedra{
    {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};

constexpr double kLeastShare = 0.02;
constexpr std::uint32_t kNone = 0xffffffffU;

class Marcher {
 public:
  Marcher(const Lattice& lattice, std::span<const float> values, const Crossing& crossing)
      : lattice_(lattice), values_(values), crossing_(crossing) {
    const auto plane = static_cast<std::size_t>(lattice.count[0] * lattice.count[1]);
    // An edge belongs to its lower end; slabs of two layers of nodes are enough.
    for (auto& slab : vertex_) slab.assign(8 * plane, kNone);
  }

  geometry::TriangleMesh run() {
    for (std::int64_t k = 0; k + 1 < lattice_.count[2]; ++k) {
      if (k > 0) {
        std::swap(vertex_[0], vertex_[1]);
        std::fill(vertex_[1].begin(), vertex_[1].end(), kNone);
      }
      layer_ = k;
      for (std::int64_t j = 0; j + 1 < lattice_.count[1]; ++j)
        for (std::int64_t i = 0; i + 1 < lattice_.count[0]; ++i) cube(i, j, k);
    }
    return std::move(mesh_);
  }

 private:
  void cube(std::int64_t i, std::int64_t j, std::int64_t k) {
    std::array<std::size_t, 8> node{};
    unsigned inside = 0;
    for (unsigned c = 0; c < 8; ++c) {
      node[c] = lattice_.index(i + (c & 1U), j + ((c >> 1U) & 1U), k + ((c >> 2U) & 1U));
      if (values_[node[c]] < 0.0F) inside |= 1U << c;
    }
    if (inside == 0 || inside == 255) return;
    for (const auto& t : kTetrahedra) tetrahedron(t, node, inside);
  }

  // All six tetrahedra of the cut have the same handedness.
  void tetrahedron(const std::array<int, 4>& t, const std::array<std::size_t, 8>& node, unsigned inside) {
    std::array<int, 4> in{}, out{};
    int ins = 0, outs = 0;
    bool even = true;  // whether in.., out.. is an even permutation of t
    for (int a = 0; a < 4; ++a) {
      if (((inside >> static_cast<unsigned>(t[static_cast<std::size_t>(a)])) & 1U) != 0) {
        if (outs % 2 == 1) even = !even;
        in[static_cast<std::size_t>(ins++)] = t[static_cast<std::size_t>(a)];
      } else {
        out[static_cast<std::size_t>(outs++)] = t[static_cast<std::size_t>(a)];
      }
    }
    if (ins == 0 || outs == 0) return;
    const auto v = [&](int a, int b) { return vertex(a, b, node); };
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      if (even) mesh_.triangles.push_back({a, b, c});
      else mesh_.triangles.push_back({a, c, b});
    };
    if (ins == 1) {
      add(v(in[0], out[0]), v(in[0], out[1]), v(in[0], out[2]));
    } else if (ins == 3) {
      add(v(in[0], out[0]), v(in[1], out[0]), v(in[2], out[0]));
    } else {
      const auto a = v(in[0], out[0]), b = v(in[0], out[1]), c = v(in[1], out[1]), d = v(in[1], out[0]);
      add(a, b, c);
      add(a, c, d);
    }
  }

  std::uint32_t vertex(int inner, int outer, const std::array<std::size_t, 8>& node) {
    const int low = std::min(inner, outer), way = inner ^ outer;
    const std::size_t base = node[static_cast<std::size_t>(low)];
    const auto plane = static_cast<std::size_t>(lattice_.count[0] * lattice_.count[1]);
    const std::size_t slab = base / plane == static_cast<std::size_t>(layer_) ? 0 : 1;
    auto& slot = vertex_[slab][8 * (base % plane) + static_cast<std::size_t>(way)];
    if (slot == kNone) {
      const std::size_t a = node[static_cast<std::size_t>(inner)], b = node[static_cast<std::size_t>(outer)];
      const double share = std::clamp(crossing_(a, b), kLeastShare, 1.0 - kLeastShare);
      slot = static_cast<std::uint32_t>(mesh_.vertices.size());
      mesh_.vertices.push_back(lattice_.node(a) + share * (lattice_.node(b) - lattice_.node(a)));
    }
    return slot;
  }

  const Lattice& lattice_;
  std::span<const float> values_;
  const Crossing& crossing_;
  std::array<std::vector<std::uint32_t>, 2> vertex_;
  std::int64_t layer_ = 0;
  geometry::TriangleMesh mesh_;
};

std::uint32_t root(std::vector<std::uint32_t>& parent, std::uint32_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

}  // namespace

geometry::TriangleMesh march_tetrahedra(const Lattice& lattice, std::span<const float> values,
                                        const Crossing& crossing) {
  return Marcher(lattice, values, crossing).run();
}

geometry::TriangleMesh largest_piece(const geometry::TriangleMesh& mesh, std::size_t& dropped) {
  std::vector<std::uint32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0U);
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 1; k < 3; ++k) {
      const auto a = root(parent, t[0]), b = root(parent, t[k]);
      parent[std::max(a, b)] = std::min(a, b);
    }
  std::vector<double> volume(mesh.vertices.size(), 0.0);
  const Vec3 origin = mesh.vertices.empty() ? Vec3(Vec3::Zero()) : mesh.bounds().centre();
  for (const auto& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]] - origin, b = mesh.vertices[t[1]] - origin, c = mesh.vertices[t[2]] - origin;
    volume[root(parent, t[0])] += a.x() * (b.y() * c.z() - b.z() * c.y()) - a.y() * (b.x() * c.z() - b.z() * c.x()) +
                                  a.z() * (b.x() * c.y() - b.y() * c.x());
  }
  std::size_t pieces = 0, best = 0;
  for (std::uint32_t v = 0; v < parent.size(); ++v) {
    if (root(parent, v) == v && volume[v] != 0.0) ++pieces;
    if (volume[v] > volume[best]) best = v;
  }
  dropped = pieces > 0 ? pieces - 1 : 0;
  geometry::TriangleMesh result;
  std::vector<std::uint32_t> index(mesh.vertices.size(), kNone);
  for (const auto& t : mesh.triangles) {
    if (root(parent, t[0]) != best) continue;
    Triangle kept{};
    for (std::size_t k = 0; k < 3; ++k) {
      if (index[t[k]] == kNone) {
        index[t[k]] = static_cast<std::uint32_t>(result.vertices.size());
        result.vertices.push_back(mesh.vertices[t[k]]);
      }
      kept[k] = index[t[k]];
    }
    result.triangles.push_back(kept);
  }
  return result;
}

}  // namespace cairn::surface
