#include "segmentation/plan_index.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.hpp"

namespace cairn::segmentation {
namespace {

TEST(PlanIndex, AgreesWithLookingAtEveryPoint) {
  base::Random random(3, "plan", 0);
  std::vector<geometry::Vec3> points;
  for (int i = 0; i < 3000; ++i) points.emplace_back(random.uniform(-30, 50), random.uniform(0, 20), random.uniform());
  points.emplace_back(std::nan(""), 0, 0);
  for (const double cell : {0.3, 1.0, 100.0}) {
    const PlanIndex index(points, cell);
    for (int k = 0; k < 200; ++k) {
      const geometry::Vec2 centre(random.uniform(-40, 60), random.uniform(-10, 30));
      const double radius = random.uniform(0, 15);
      std::vector<std::size_t> expected;
      for (std::size_t i = 0; i < points.size(); ++i)
        if ((points[i].head<2>() - centre).squaredNorm() <= radius * radius) expected.push_back(i);
      EXPECT_EQ(index.within(centre, radius), expected);
    }
  }
}

TEST(PlanIndex, EmptyAndHugeExtent) {
  EXPECT_TRUE(PlanIndex({}).within({0, 0}, 10).empty());
  const std::vector<geometry::Vec3> far = {{0, 0, 0}, {1e9, 1e9, 0}};
  EXPECT_EQ(PlanIndex(far).within({1e9, 1e9}, 1).size(), 1U);
}

}  // namespace
}  // namespace cairn::segmentation
