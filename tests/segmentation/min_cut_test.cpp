#include "segmentation/min_cut.hpp"

#include <gtest/gtest.h>

#include <bit>

#include "base/random.hpp"

namespace cairn::segmentation {
namespace {

double cost_of(const std::vector<CutEdge>& edges, const std::vector<float>& source, const std::vector<float>& sink,
               std::uint32_t on_source) {
  double cost = 0.0;
  for (const auto& e : edges)
    if (((on_source >> e.a) & 1U) != ((on_source >> e.b) & 1U)) cost += static_cast<double>(e.capacity);
  for (std::size_t i = 0; i < source.size(); ++i)
    cost += static_cast<double>(((on_source >> i) & 1U) != 0 ? sink[i] : source[i]);
  return cost;
}

TEST(MinimumCut, IsTheLeastOfAllCuts) {
  constexpr double kRounding = 1e-4;  // capacities of about 1 in single precision, a few dozen sums
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    base::Random random(seed, "min_cut", 0);
    const std::size_t n = 3 + random.below(8);
    std::vector<CutEdge> edges;
    std::vector<float> source(n, 0.0F), sink(n, 0.0F);
    for (std::uint32_t a = 0; a < n; ++a) {
      for (std::uint32_t b = a + 1; b < n; ++b)
        if (random.uniform() < 0.6) edges.push_back({a, b, static_cast<float>(random.uniform(0.0, 2.0))});
      if (random.uniform() < 0.5) source[a] = static_cast<float>(random.uniform(0.0, 3.0));
      if (random.uniform() < 0.5) sink[a] = static_cast<float>(random.uniform(0.0, 3.0));
    }
    const auto side = minimum_cut(n, edges, source, sink);
    std::uint32_t found = 0;
    for (std::uint32_t i = 0; i < n; ++i) found |= static_cast<std::uint32_t>(side[i]) << i;
    double least = 1e300;
    for (std::uint32_t cut = 0; cut < (1U << n); ++cut) least = std::min(least, cost_of(edges, source, sink, cut));
    EXPECT_NEAR(cost_of(edges, source, sink, found), least, kRounding) << "seed " << seed;
  }
}

TEST(MinimumCut, NodesThatNoTerminalReachesAreNotOnTheSourcesSide) {
  const auto side = minimum_cut(3, {{0, 1, 1.0F}}, {5.0F, 0.0F, 0.0F}, {0.0F, 5.0F, 0.0F});
  EXPECT_EQ(side, (std::vector<std::uint8_t>{1, 0, 0}));
  EXPECT_TRUE(minimum_cut(0, {}, {}, {}).empty());
}

}  // namespace
}  // namespace cairn::segmentation
