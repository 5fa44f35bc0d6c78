// How uncertain a completeness is, facets being neighbours of one another.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "coverage/audit.hpp"
#include "geometry/triangle_mesh.hpp"

namespace cairn::coverage {

struct BootstrapOptions {
  std::int64_t replicates = 1000;  // 0: no interval
  double block_m = 0.0;            // edge of a block; 0: so that about 100 of them cover the surface

  void visit(base::OptionVisitor& v) {
    v.integer("bootstrap", replicates, 0, 1000000, "draws for the interval of completeness; 0 = no interval");
    v.real("bootstrap-block-m", block_m, 0.0, 1e6, "edge of the blocks that are drawn, m; 0 = about 100 blocks");
  }
};

struct CompletenessInterval {
  double low = 0.0, high = 0.0;  // 2.5 % and 97.5 % of the draws
  double block_m = 0.0;
  std::size_t blocks = 0;
};

// Block bootstrap (Hall 1985; Lahiri 2003, ch. 12): the surface is cut into cubes on a fixed lattice; draws of as many
// cubes with replacement give completeness = passed area / observed area. It answers: how would the figure vary over
// surfaces like this one? Failures that reach farther than a block make it too narrow. Empty where fewer than 8 blocks
// hold observed area. Random numbers: stage "coverage_bootstrap", record = draw.
// Cost: n log n in facets, draws x blocks.
[[nodiscard]] std::optional<CompletenessInterval> completeness_interval(const geometry::TriangleMesh& mesh,
                                                                        const Audit& audit,
                                                                        const BootstrapOptions& options,
                                                                        const base::RunContext& ctx);

}  // namespace cairn::coverage
