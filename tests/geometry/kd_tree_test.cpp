#include "geometry/kd_tree.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "base/random.hpp"

namespace cairn::geometry {
namespace {

std::vector<KdTree::Neighbour> brute_force(const std::vector<Vec3>& points, const Vec3& query) {
  std::vector<KdTree::Neighbour> all;
  for (std::size_t i = 0; i < points.size(); ++i) all.push_back({i, (points[i] - query).squaredNorm()});
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return std::pair(a.squared_distance, a.index) < std::pair(b.squared_distance, b.index);
  });
  return all;
}

TEST(KdTree, EqualsBruteForceOnUniformAndGriddedPoints) {
  base::Random random(1, "kd_tree", 0);
  for (const bool gridded : {false, true}) {
    std::vector<Vec3> points(800);
    for (auto& p : points) {
      for (int k = 0; k < 3; ++k)
        p[k] = gridded ? static_cast<double>(random.below(8)) + 0.1 * k : random.uniform(-5, 5);
    }
    const KdTree tree(points);
    for (int q = 0; q < 50; ++q) {
      const Vec3 query(random.uniform(-5, 8), random.uniform(-5, 8), random.uniform(-5, 8));
      const auto expected = brute_force(points, query);
      const double radius = random.uniform(0.5, 3.0);
      const auto within = tree.within(query, radius);
      std::size_t count = 0;
      while (count < expected.size() && expected[count].squared_distance < radius * radius) ++count;
      ASSERT_EQ(within.size(), count);
      for (std::size_t i = 0; i < count; ++i) EXPECT_EQ(within[i].index, expected[i].index);
      const auto nearest = tree.nearest(query, 5);
      ASSERT_EQ(nearest.size(), 5U);
      for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(nearest[i].squared_distance, expected[i].squared_distance);
    }
  }
}

TEST(KdTree, EmptyAndFewerThanAsked) {
  const std::vector<Vec3> none, one{{1, 2, 3}};
  EXPECT_TRUE(KdTree(none).nearest(Vec3::Zero(), 3).empty());
  EXPECT_EQ(KdTree(one).nearest(Vec3::Zero(), 3).size(), 1U);
}

}  // namespace
}  // namespace cairn::geometry
