// Minimum cut of a graph in two.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cairn::segmentation {

struct CutEdge {
  std::uint32_t a = 0, b = 0;  // nodes
  float capacity = 0.0F;       // cost of parting them, the same both ways, >= 0, finite
};

// Nodes on the source's side (1) of a cut of least total cost between the terminals: Boykov & Kolmogorov 2004
// ("An experimental comparison of min-cut/max-flow algorithms", PAMI 26:1124), two search trees that are kept.
// to_source, to_sink: per node, cost of parting it from that terminal, >= 0, finite. Of several least cuts the one
// nearest to the source is taken, so the result does not depend on the order of edges beyond rounding. Nodes that no
// flow path decides lie on the sink's side. Typically a few passes over the edges.
[[nodiscard]] std::vector<std::uint8_t> minimum_cut(std::size_t nodes, const std::vector<CutEdge>& edges,
                                                    const std::vector<float>& to_source,
                                                    const std::vector<float>& to_sink);

}  // namespace cairn::segmentation
