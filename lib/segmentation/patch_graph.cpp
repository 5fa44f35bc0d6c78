#include "segmentation/patch_graph.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

#include "base/parallel.hpp"
#include "geometry/kd_tree.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Vec3;

constexpr double kPairReach = 2.0;     // steps
constexpr double kSmoothShare = 0.35;  // of the reach
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
    const auto count = static_cast<double>(k - first);
    graph.position.push_back(points[keyed[first].point] + sum / count);
  }
  const auto near = neighbours_within(graph, kPairReach);
  for (std::uint32_t i = 0; i < graph.size(); ++i)
    for (const auto j : near.of(i))
      if (i < j) graph.pairs.push_back({i, j});
  return graph;
}

void measure_concavity(PatchGraph& graph, const geometry::Vec2& axis, double reach) {
  constexpr double kUpward = 0.3;  // of the way out: rise over run
  const std::size_t n = graph.size();
  const auto wide = neighbours_within(graph, reach / graph.step);
  const auto near = neighbours_within(graph, kSmoothShare * reach / graph.step);
  std::vector<double> raw(n, 0.0);
  base::parallel_for(n, kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto neighbours = wide.of(i);
      if (neighbours.empty()) continue;
      Vec3 sum = Vec3::Zero();
      for (const auto j : neighbours) sum += graph.position[j] - graph.position[i];
      const geometry::Vec2 out = graph.position[i].head<2>() - axis;
      const double length = std::max(out.norm(), 1e-9);
      const Vec3 way = Vec3(out.x() / length, out.y() / length, kUpward).normalized();
      raw[i] = sum.dot(way) / (static_cast<double>(neighbours.size() + 1) * reach);
    }
  });
  graph.concavity.assign(n, 0.0F);
  for (std::size_t i = 0; i < n; ++i) {
    double sum = raw[i];
    for (const auto j : near.of(i)) sum += raw[j];
    graph.concavity[i] = static_cast<float>(sum / static_cast<double>(near.of(i).size() + 1));
  }
}

}  // namespace cairn::segmentation
