#include "segmentation/min_cut.hpp"

#include <algorithm>
#include <deque>
#include <limits>

namespace cairn::segmentation {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint32_t kTerminal = kNone - 1;
constexpr std::uint32_t kOrphan = kNone - 2;
constexpr float kSpent = 1e-6F;  // a residual below this counts as used up: single precision leaves crumbs

class Flow {
 public:
  Flow(std::size_t nodes, const std::vector<CutEdge>& edges, const std::vector<float>& to_source,
       const std::vector<float>& to_sink)
      : first_(nodes + 1, 0),
        parent_(nodes, kNone),
        tree_(nodes, 0),
        residual_terminal_(nodes),
        stamp_(nodes, 0),
        depth_(nodes, 0),
        queued_(nodes, 0) {
    for (const auto& e : edges) ++first_[e.a + 1], ++first_[e.b + 1];
    for (std::size_t i = 0; i < nodes; ++i) first_[i + 1] += first_[i];
    auto next = first_;
    arcs_.resize(2 * edges.size());
    for (const auto& e : edges) {
      const auto forward = next[e.a]++, back = next[e.b]++;
      arcs_[forward] = {e.b, back, e.capacity};
      arcs_[back] = {e.a, forward, e.capacity};
    }
    for (std::size_t i = 0; i < nodes; ++i) residual_terminal_[i] = to_source[i] - to_sink[i];
  }

  std::vector<std::uint8_t> run() {
    const auto nodes = static_cast<std::uint32_t>(parent_.size());
    for (std::uint32_t i = 0; i < nodes; ++i) {
      if (residual_terminal_[i] > 0.0F) adopt_terminal(i, 1);
      else if (residual_terminal_[i] < 0.0F) adopt_terminal(i, 2);
    }
    while (true) {
      const std::uint32_t middle = grow();
      if (middle == kNone) break;
      ++time_;
      augment(middle);
      adopt();
    }
    std::vector<std::uint8_t> source(nodes);
    for (std::uint32_t i = 0; i < nodes; ++i) source[i] = tree_[i] == 1 ? 1 : 0;
    return source;
  }

 private:
  struct Arc {
    std::uint32_t head = 0, sister = 0;
    float residual = 0.0F;
  };

  void adopt_terminal(std::uint32_t i, std::uint8_t tree) {
    tree_[i] = tree;
    parent_[i] = kTerminal;
    depth_[i] = 1;
    activate(i);
  }
  void activate(std::uint32_t i) {
    if (queued_[i] != 0) return;
    queued_[i] = 1;
    active_.push_back(i);
  }

  // An arc from the source's tree to the sink's, or kNone when there is none left.
  std::uint32_t grow() {
    while (!active_.empty()) {
      const std::uint32_t i = active_.front();
      if (parent_[i] != kNone) {
        for (std::uint32_t a = first_[i]; a < first_[i + 1]; ++a) {
          const float open = tree_[i] == 1 ? arcs_[a].residual : arcs_[arcs_[a].sister].residual;
          if (open <= kSpent) continue;
          const std::uint32_t j = arcs_[a].head;
          if (parent_[j] == kNone) {
            tree_[j] = tree_[i];
            parent_[j] = arcs_[a].sister;
            stamp_[j] = stamp_[i];
            depth_[j] = depth_[i] + 1;
            activate(j);
          } else if (tree_[j] != tree_[i]) {
            return tree_[i] == 1 ? a : arcs_[a].sister;
          } else if (stamp_[j] <= stamp_[i] && depth_[j] > depth_[i]) {
            parent_[j] = arcs_[a].sister;  // a shorter way to the root
            stamp_[j] = stamp_[i];
            depth_[j] = depth_[i] + 1;
          }
        }
      }
      active_.pop_front();
      queued_[i] = 0;
    }
    return kNone;
  }

  void orphan(std::uint32_t i) {
    parent_[i] = kOrphan;
    orphans_.push_back(i);
  }

  void augment(std::uint32_t middle) {
    float least = arcs_[middle].residual;
    const std::uint32_t start = arcs_[arcs_[middle].sister].head, end = arcs_[middle].head;
    std::uint32_t i = start;
    for (; parent_[i] != kTerminal; i = arcs_[parent_[i]].head)
      least = std::min(least, arcs_[arcs_[parent_[i]].sister].residual);
    least = std::min(least, residual_terminal_[i]);
    for (i = end; parent_[i] != kTerminal; i = arcs_[parent_[i]].head)
      least = std::min(least, arcs_[parent_[i]].residual);
    least = std::min(least, -residual_terminal_[i]);

    arcs_[middle].residual -= least;
    arcs_[arcs_[middle].sister].residual += least;
    for (i = start; parent_[i] != kTerminal;) {
      Arc& up = arcs_[parent_[i]];
      Arc& down = arcs_[up.sister];
      const std::uint32_t next = up.head;
      up.residual += least;
      down.residual -= least;
      if (down.residual <= kSpent) orphan(i);
      i = next;
    }
    residual_terminal_[i] -= least;
    if (residual_terminal_[i] <= kSpent) orphan(i);
    for (i = end; parent_[i] != kTerminal;) {
      Arc& up = arcs_[parent_[i]];
      Arc& down = arcs_[up.sister];
      const std::uint32_t next = up.head;
      down.residual += least;
      up.residual -= least;
      if (up.residual <= kSpent) orphan(i);
      i = next;
    }
    residual_terminal_[i] += least;
    if (-residual_terminal_[i] <= kSpent) orphan(i);
  }

  // Steps from i to its terminal, or the largest number where it hangs in the air.
  std::uint32_t distance_to_root(std::uint32_t i) {
    std::uint32_t steps = 0, j = i;
    while (true) {
      if (stamp_[j] == time_) {
        steps += depth_[j];
        break;
      }
      ++steps;
      if (parent_[j] == kTerminal) {
        stamp_[j] = time_;
        depth_[j] = 1;
        break;
      }
      if (parent_[j] == kOrphan || parent_[j] == kNone) return kNone;
      j = arcs_[parent_[j]].head;
    }
    const std::uint32_t found = steps;
    for (j = i; stamp_[j] != time_; j = arcs_[parent_[j]].head) {
      stamp_[j] = time_;
      depth_[j] = steps--;
    }
    return found;
  }

  void adopt() {
    while (!orphans_.empty()) {
      const std::uint32_t i = orphans_.front();
      orphans_.pop_front();
      std::uint32_t best = kNone, best_distance = kNone;
      for (std::uint32_t a = first_[i]; a < first_[i + 1]; ++a) {
        const std::uint32_t j = arcs_[a].head;
        const float open = tree_[i] == 1 ? arcs_[arcs_[a].sister].residual : arcs_[a].residual;
        if (open <= kSpent || tree_[j] != tree_[i] || parent_[j] == kNone) continue;
        const std::uint32_t d = distance_to_root(j);
        if (d < best_distance) best_distance = d, best = a;
      }
      if (best != kNone) {
        parent_[i] = best;
        stamp_[i] = time_;
        depth_[i] = best_distance + 1;
        continue;
      }
      for (std::uint32_t a = first_[i]; a < first_[i + 1]; ++a) {
        const std::uint32_t j = arcs_[a].head;
        if (tree_[j] != tree_[i] || parent_[j] == kNone) continue;
        const float open = tree_[i] == 1 ? arcs_[arcs_[a].sister].residual : arcs_[a].residual;
        if (open > kSpent) activate(j);
        if (parent_[j] != kTerminal && parent_[j] != kOrphan && arcs_[parent_[j]].head == i) orphan(j);
      }
      tree_[i] = 0;
      parent_[i] = kNone;
    }
  }

  std::vector<std::uint32_t> first_;
  std::vector<Arc> arcs_;
  std::vector<std::uint32_t> parent_;
  std::vector<std::uint8_t> tree_;
  std::vector<float> residual_terminal_;
  std::vector<std::uint32_t> stamp_, depth_;
  std::vector<std::uint8_t> queued_;
  std::deque<std::uint32_t> active_, orphans_;
  std::uint32_t time_ = 0;
};

}  // namespace

std::vector<std::uint8_t> minimum_cut(std::size_t nodes, const std::vector<CutEdge>& edges,
                                      const std::vector<float>& to_source, const std::vector<float>& to_sink) {
  return Flow(nodes, edges, to_source, to_sink).run();
}

}  // namespace cairn::segmentation
