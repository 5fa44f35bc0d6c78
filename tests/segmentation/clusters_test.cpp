#include "segmentation/clusters.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "base/random.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Vec3;

TEST(Clusters, AgreeWithUnionFind) {
  base::Random random(5, "clusters", 0);
  std::vector<Vec3> points;
  for (int i = 0; i < 300; ++i)
    points.emplace_back(500000 + random.uniform(0, 5), 3.8e6 + random.uniform(0, 5), random.uniform(0, 1));
  const double tolerance = 0.35;
  std::vector<std::size_t> root(points.size());
  std::iota(root.begin(), root.end(), 0U);
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < points.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if ((points[i] - points[j]).norm() < tolerance && root[i] != root[j]) {
          root[i] = root[j] = std::min(root[i], root[j]);
          changed = true;
        }
  }
  const auto clusters = euclidean_clusters(points, tolerance);
  std::size_t total = 0;
  for (const auto& cluster : clusters) {
    total += cluster.size();
    for (const std::size_t i : cluster) EXPECT_EQ(root[i], root[cluster.front()]);
    EXPECT_EQ(static_cast<std::size_t>(std::count(root.begin(), root.end(), root[cluster.front()])), cluster.size());
  }
  EXPECT_EQ(total, points.size());
  for (std::size_t k = 1; k < clusters.size(); ++k) EXPECT_GE(clusters[k - 1].size(), clusters[k].size());
}

TEST(Clusters, NothingFromNothing) {
  EXPECT_TRUE(euclidean_clusters({}, 1.0).empty());
}

}  // namespace
}  // namespace cairn::segmentation
