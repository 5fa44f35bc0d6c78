#include "adjustment/tracks.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace cairn::adjustment {
namespace {

class Forest {
 public:
  explicit Forest(const std::vector<TrackNode>& nodes) : parent_(nodes.size()), images_(nodes.size()) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
    for (std::size_t i = 0; i < nodes.size(); ++i) images_[i] = {nodes[i].image};
  }

  std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  // False where the two share an image.
  bool join(std::size_t a, std::size_t b) {
    a = root(a);
    b = root(b);
    if (a == b) return true;
    auto& of_a = images_[a];
    auto& of_b = images_[b];
    std::vector<std::uint32_t> both;
    std::set_intersection(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(), std::back_inserter(both));
    if (!both.empty()) return false;
    std::vector<std::uint32_t> merged;
    std::merge(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(), std::back_inserter(merged));
    of_a = std::move(merged);
    of_b.clear();
    parent_[b] = a;
    return true;
  }

 private:
  std::vector<std::size_t> parent_;
  std::vector<std::vector<std::uint32_t>> images_;  // of a root, ascending
};

}  // namespace

Tracks build_tracks(std::span<const TrackEdge> edges) {
  std::vector<TrackEdge> sorted(edges.begin(), edges.end());
  for (auto& edge : sorted)
    if (edge.b < edge.a) std::swap(edge.a, edge.b);
  std::sort(sorted.begin(), sorted.end(), [](const TrackEdge& x, const TrackEdge& y) {
    return std::tie(y.closeness, x.a, x.b) < std::tie(x.closeness, y.a, y.b);
  });
  std::vector<TrackNode> nodes;
  for (const auto& edge : sorted) {
    nodes.push_back(edge.a);
    nodes.push_back(edge.b);
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  const auto index_of = [&](const TrackNode& node) {
    return static_cast<std::size_t>(std::lower_bound(nodes.begin(), nodes.end(), node) - nodes.begin());
  };

  Tracks result;
  Forest forest(nodes);
  for (const auto& edge : sorted)
    if (!forest.join(index_of(edge.a), index_of(edge.b))) ++result.refused;
  std::vector<std::vector<TrackNode>> by_root(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) by_root[forest.root(i)].push_back(nodes[i]);
  for (auto& track : by_root)
    if (track.size() >= 2) result.tracks.push_back(std::move(track));
  std::sort(result.tracks.begin(), result.tracks.end(),
            [](const auto& x, const auto& y) { return x.front() < y.front(); });
  return result;
}

}  // namespace cairn::adjustment
