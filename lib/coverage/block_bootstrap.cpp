#include "coverage/block_bootstrap.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/parallel.hpp"

namespace cairn::coverage {
namespace {

using geometry::Vec3;

constexpr double kBlocks = 100.0;   // aimed at
constexpr std::size_t kFewest = 8;  // an interval from fewer would only look like one
constexpr double kFarthest = 1e8;   // m; as visibility::Scene

struct Block {
  std::array<std::int64_t, 3> cell{};
  double passed = 0.0, observed = 0.0;
};

struct Facet {
  Vec3 centre;
  double area = 0.0;
  bool passed = false;
};

std::vector<Facet> observed_facets(const geometry::TriangleMesh& mesh, const Audit& audit) {
  std::vector<Facet> facets;
  const std::size_t count = mesh.vertices.size();
  for (std::size_t i = 0; i < audit.verdicts.size(); ++i) {
    const auto& t = mesh.triangles[i];
    if (audit.verdicts[i] == Verdict::no_data || t[0] >= count || t[1] >= count || t[2] >= count) continue;
    const Facet facet{mesh.centroid(i), mesh.area_vector(i).norm(), audit.verdicts[i] == Verdict::passed};
    if (facet.centre.allFinite() && facet.centre.cwiseAbs().maxCoeff() <= kFarthest && std::isfinite(facet.area) &&
        facet.area > 0.0)
      facets.push_back(facet);
  }
  return facets;
}

std::vector<Block> blocks_of(const std::vector<Facet>& facets, double edge) {
  std::vector<Block> single;
  single.reserve(facets.size());
  for (const Facet& f : facets) {
    Block b;
    for (int k = 0; k < 3; ++k)
      b.cell[static_cast<std::size_t>(k)] = static_cast<std::int64_t>(std::floor(f.centre[k] / edge));
    b.observed = f.area;
    b.passed = f.passed ? f.area : 0.0;
    single.push_back(b);
  }
  std::stable_sort(single.begin(), single.end(), [](const Block& a, const Block& b) { return a.cell < b.cell; });
  std::vector<Block> blocks;
  for (const Block& b : single) {
    if (blocks.empty() || blocks.back().cell != b.cell) blocks.push_back({b.cell, 0.0, 0.0});
    blocks.back().observed += b.observed;
    blocks.back().passed += b.passed;
  }
  return blocks;
}

}  // namespace

std::optional<CompletenessInterval> completeness_interval(const geometry::TriangleMesh& mesh, const Audit& audit,
                                                          const BootstrapOptions& options,
                                                          const base::RunContext& ctx) {
  BootstrapOptions checked = options;
  base::validate(base::bind_options(checked), "completeness interval");
  if (options.replicates == 0) return std::nullopt;
  const std::vector<Facet> facets = observed_facets(mesh, audit);
  if (facets.empty()) return std::nullopt;
  CompletenessInterval result;
  result.block_m = options.block_m;
  if (result.block_m <= 0.0) {
    double area = 0.0;
    for (const Facet& f : facets) area += f.area;
    result.block_m = std::sqrt(area / kBlocks);
  }
  // Keeps the numbers of the lattice's cells within 64 bits.
  result.block_m = std::max(result.block_m, 1e-6);
  const std::vector<Block> blocks = blocks_of(facets, result.block_m);
  result.blocks = blocks.size();
  if (blocks.size() < kFewest) return std::nullopt;
  const auto replicates = static_cast<std::size_t>(options.replicates);
  std::vector<double> draws(replicates, 0.0);
  base::parallel_for(replicates, 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      base::Random random = ctx.random("coverage_bootstrap", i);
      double passed = 0.0, observed = 0.0;
      for (std::size_t k = 0; k < blocks.size(); ++k) {
        const Block& b = blocks[random.below(blocks.size())];
        passed += b.passed;
        observed += b.observed;
      }
      draws[i] = passed / observed;
    }
  });
  std::sort(draws.begin(), draws.end());
  const auto at = [&](double share) {
    return draws[std::min(replicates - 1, static_cast<std::size_t>(share * static_cast<double>(replicates)))];
  };
  result.low = at(0.025);
  result.high = at(0.975);
  return result;
}

}  // namespace cairn::coverage
