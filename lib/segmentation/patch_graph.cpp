#include "segmentation/patch_graph.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

#include "base/parallel.hpp"
#include "geometry/kd_tree.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Mat3;
using geometry::Vec3;

constexpr double kPairReach = 2.5;       // steps
constexpr double kNormalReach = 2.5;     // steps
constexpr double kConcavityReach = 4.0;  // steps: half the width over which a bend is felt
constexpr std::size_t kGrain = 512;

struct Neighbours {
  std::vector<std::uint32_t> start, index;
  [[nodiscard]] std::span<const std::uint32_t> of(std::size_t i) const {
    return std::span(index).subspan(start[i], start[i + 1] - start[i]);
  }
};

// Nodes stand in cubes: those near to one are found in the cubes about it, without a tree.
class CubeIndex {
 public:
  CubeIndex(const std::vector<std::array<std::int64_t, 3>>& cubes) : cubes_(cubes) {}

  [[nodiscard]] Neighbours within(std::span<const Vec3> positions, double step, double reach) const {
    const auto cells = static_cast<std::int64_t>(std::ceil(reach));
    const double limit = reach * step * reach * step;
    const std::size_t n = cubes_.size();
    std::vector<std::vector<std::uint32_t>> found(n);
    base::parallel_for(n, kGrain, [&](std::size_t begin, std::size_t end) {
      // Rows of cubes along z are runs of the sorted list; a cursor a row follows the nodes.
      const auto width = static_cast<std::size_t>(2 * cells + 1);
      std::vector<std::size_t> cursor(width * width, n + 1);
      for (std::size_t i = begin; i < end; ++i) {
        const auto& c = cubes_[i];
        for (std::int64_t dx = -cells; dx <= cells; ++dx)
          for (std::int64_t dy = -cells; dy <= cells; ++dy) {
            const std::array<std::int64_t, 3> low = {c[0] + dx, c[1] + dy, c[2] - cells};
            std::size_t& at =
                cursor[static_cast<std::size_t>(dx + cells) * width + static_cast<std::size_t>(dy + cells)];
            if (at > n)
              at = static_cast<std::size_t>(std::lower_bound(cubes_.begin(), cubes_.end(), low) - cubes_.begin());
            while (at < n && cubes_[at] < low) ++at;
            for (std::size_t j = at;
                 j < n && cubes_[j][0] == low[0] && cubes_[j][1] == low[1] && cubes_[j][2] <= c[2] + cells; ++j)
              if (j != i && (positions[j] - positions[i]).squaredNorm() <= limit)
                found[i].push_back(static_cast<std::uint32_t>(j));
          }
      }
    });
    Neighbours all;
    all.start.assign(1, 0);
    for (const auto& f : found) {
      all.index.insert(all.index.end(), f.begin(), f.end());
      all.start.push_back(static_cast<std::uint32_t>(all.index.size()));
    }
    return all;
  }

 private:
  const std::vector<std::array<std::int64_t, 3>>& cubes_;
};

std::array<std::int64_t, 3> cube_of(const Vec3& p, double step) {
  return {static_cast<std::int64_t>(std::floor(p.x() / step)), static_cast<std::int64_t>(std::floor(p.y() / step)),
          static_cast<std::int64_t>(std::floor(p.z() / step))};
}

void fit_normals(PatchGraph& graph, const Neighbours& near) {
  const std::size_t n = graph.size();
  graph.normal.assign(n, Vec3::UnitZ());
  graph.planarity.assign(n, 0.0F);
  base::parallel_for(n, kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto neighbours = near.of(i);
      if (neighbours.size() < 3) continue;
      double total = graph.weight[i];
      Vec3 mean = total * graph.position[i];
      for (const auto j : neighbours) total += graph.weight[j], mean += graph.weight[j] * graph.position[j];
      mean /= total;
      Mat3 scatter = Mat3::Zero();
      const auto add = [&](std::size_t j) {
        const Vec3 d = graph.position[j] - mean;
        scatter += graph.weight[j] * d * d.transpose();
      };
      add(i);
      for (const auto j : neighbours) add(j);
      Eigen::SelfAdjointEigenSolver<Mat3> solver;
      solver.computeDirect(scatter);
      graph.normal[i] = solver.eigenvectors().col(0).normalized();
      const auto& l = solver.eigenvalues();
      graph.planarity[i] = static_cast<float>(l[1] > 0.0 ? std::clamp(1.0 - l[0] / l[1], 0.0, 1.0) : 0.0);
      if (!graph.normal[i].allFinite()) graph.normal[i] = Vec3::UnitZ();
    }
  });
}

// Averages each normal with those near it that agree: noise goes, creases stay (bilateral filter).
void sharpen_normals(PatchGraph& graph, const Neighbours& near) {
  constexpr double kSpread = 0.06;  // 1 - cos of the angle at which a neighbour's say falls to 1 / e: 20 deg
  std::vector<Vec3> next(graph.size());
  base::parallel_for(graph.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Vec3 sum = (0.2 + graph.planarity[i]) * graph.normal[i];
      for (const auto j : near.of(i)) {
        const double cosine = graph.normal[i].dot(graph.normal[j]);
        sum += (0.2 + graph.planarity[j]) * std::exp((cosine - 1.0) / kSpread) * graph.normal[j];
      }
      next[i] = sum.normalized();
    }
  });
  graph.normal = std::move(next);
}

void measure_concavity(PatchGraph& graph, const Neighbours& near) {
  graph.concavity.assign(graph.size(), 0.0F);
  base::parallel_for(graph.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      double sum = 0.0, total = 0.0;
      for (const auto j : near.of(i)) {
        const Vec3 d = graph.position[j] - graph.position[i];
        const double length = d.norm();
        if (length <= 0.0) continue;
        const double weight = length;
        sum += weight * (graph.normal[i] - graph.normal[j]).dot(d) / length;
        total += weight;
      }
      if (total > 0.0) graph.concavity[i] = static_cast<float>(sum / total);
    }
  });
}

Neighbours neighbours_within(const PatchGraph& graph, double reach) {
  std::vector<std::array<std::int64_t, 3>> cubes;
  cubes.reserve(graph.size());
  for (const Vec3& p : graph.position) cubes.push_back(cube_of(p, graph.step));
  return CubeIndex(cubes).within(graph.position, graph.step, reach);
}

}  // namespace

double point_spacing(std::span<const Vec3> points) {
  if (points.size() < 2) return 0.0;
  constexpr std::size_t kSample = 2000;
  const geometry::KdTree tree(points);
  const std::size_t stride = std::max<std::size_t>(1, points.size() / kSample);
  std::vector<double> distance;
  for (std::size_t i = 0; i < points.size(); i += stride)
    distance.push_back(std::sqrt(tree.nearest(points[i], 2).back().squared_distance));
  const auto middle = distance.begin() + static_cast<std::ptrdiff_t>(distance.size() / 2);
  std::nth_element(distance.begin(), middle, distance.end());
  return *middle;
}

PatchGraph build_patch_graph(std::span<const Vec3> points, double step) {
  PatchGraph graph;
  graph.step = step;
  struct Keyed {
    std::array<std::int64_t, 3> cube;
    std::uint32_t point;
  };
  std::vector<Keyed> keyed;
  keyed.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    keyed.push_back({cube_of(points[i], step), static_cast<std::uint32_t>(i)});
  std::sort(keyed.begin(), keyed.end(),
            [](const Keyed& a, const Keyed& b) { return std::tie(a.cube, a.point) < std::tie(b.cube, b.point); });
  graph.node_of.resize(points.size());
  for (std::size_t k = 0; k < keyed.size();) {
    const std::size_t first = k;
    Vec3 sum = Vec3::Zero();
    for (; k < keyed.size() && keyed[k].cube == keyed[first].cube; ++k) {
      sum += points[keyed[k].point] - points[keyed[first].point];
      graph.node_of[keyed[k].point] = static_cast<std::uint32_t>(graph.position.size());
    }
    const auto count = static_cast<std::uint32_t>(k - first);
    graph.position.push_back(points[keyed[first].point] + sum / count);
    graph.weight.push_back(count);
  }
  const auto near = neighbours_within(graph, std::max(kPairReach, kNormalReach));
  fit_normals(graph, near);
  for (std::uint32_t i = 0; i < graph.size(); ++i)
    for (const auto j : near.of(i))
      if (i < j) graph.pairs.push_back({i, j});
  return graph;
}

namespace {

// Groups of nodes, each with a sign against its root.
class SignedGroups {
 public:
  explicit SignedGroups(std::size_t n) : parent_(n), flip_(n, 0) {
    for (std::size_t i = 0; i < n; ++i) parent_[i] = static_cast<std::uint32_t>(i);
  }
  // Root of i; flipped: whether i is turned against it.
  std::uint32_t root(std::uint32_t i, bool& flipped) {
    std::uint8_t sign = 0;
    std::uint32_t r = i;
    for (; parent_[r] != r; r = parent_[r]) sign ^= flip_[r];
    flipped = sign != 0;
    while (parent_[i] != r && i != r) {  // shortens the way
      const std::uint32_t next = parent_[i];
      const std::uint8_t own = flip_[i];
      parent_[i] = r;
      flip_[i] = sign;
      sign ^= own;
      i = next;
    }
    return r;
  }
  void join(std::uint32_t root_a, std::uint32_t root_b, bool flipped) {
    parent_[root_b] = root_a;
    flip_[root_b] = flipped ? 1 : 0;
  }

 private:
  std::vector<std::uint32_t> parent_;
  std::vector<std::uint8_t> flip_;
};

}  // namespace

void orient_normals(PatchGraph& graph, const geometry::Vec2& axis) {
  constexpr double kSmooth = 0.08;    // 1 - cos of the bend between neighbours up to which they are one piece
  constexpr double kUpward = 0.3;     // of the direction towards whoever looks: rise over run
  constexpr double kDecided = 0.15;   // mean cosine above which a piece's own vote counts
  const std::size_t n = graph.size();
  struct Way {
    float cost;
    std::uint32_t a, b;
  };
  std::vector<Way> ways;
  ways.reserve(graph.pairs.size());
  for (const auto& p : graph.pairs) {
    // Bends cost, and so do ways along the normal: they jump from one sheet to another.
    const Vec3 d = (graph.position[p.a] - graph.position[p.b]).normalized();
    const double off = std::max(std::abs(d.dot(graph.normal[p.a])), std::abs(d.dot(graph.normal[p.b])));
    const double cost = 1.0 - std::abs(graph.normal[p.a].dot(graph.normal[p.b])) + 0.5 * off * off;
    ways.push_back({static_cast<float>(cost), p.a, p.b});
  }
  std::sort(ways.begin(), ways.end(),
            [](const Way& x, const Way& y) { return std::tie(x.cost, x.a, x.b) < std::tie(y.cost, y.a, y.b); });
  std::vector<double> vote(n);
  std::vector<std::uint32_t> size(n, 1);
  for (std::size_t i = 0; i < n; ++i) {
    const geometry::Vec2 out = graph.position[i].head<2>() - axis;
    const double length = std::max(out.norm(), 1e-9);
    vote[i] = graph.normal[i].dot(Vec3(out.x() / length, out.y() / length, kUpward).normalized());
  }
  SignedGroups groups(n);
  for (const Way& w : ways) {
    bool flip_a = false, flip_b = false;
    std::uint32_t a = groups.root(w.a, flip_a), b = groups.root(w.b, flip_b);
    if (a == b) continue;
    const bool opposed = graph.normal[w.a].dot(graph.normal[w.b]) < 0.0;
    bool flipped = (flip_a != flip_b) != opposed;
    if (w.cost > kSmooth && std::abs(vote[a]) > kDecided * size[a] && std::abs(vote[b]) > kDecided * size[b])
      flipped = (vote[a] < 0.0) != (vote[b] < 0.0);
    if (size[a] < size[b]) std::swap(a, b);
    groups.join(a, b, flipped);
    vote[a] += flipped ? -vote[b] : vote[b];
    size[a] += size[b];
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    bool flipped = false;
    const auto root = groups.root(i, flipped);
    if ((vote[root] < 0.0) != flipped) graph.normal[i] = -graph.normal[i];
  }
  Neighbours near;
  near.start.assign(n + 1, 0);
  for (const auto& p : graph.pairs) ++near.start[p.a + 1], ++near.start[p.b + 1];
  for (std::size_t i = 0; i < n; ++i) near.start[i + 1] += near.start[i];
  near.index.resize(2 * graph.pairs.size());
  auto next = near.start;
  for (const auto& p : graph.pairs) near.index[next[p.a]++] = p.b, near.index[next[p.b]++] = p.a;
  sharpen_normals(graph, near);
  measure_concavity(graph, neighbours_within(graph, kConcavityReach));
}

}  // namespace cairn::segmentation
