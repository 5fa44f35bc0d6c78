#include "geometry/point_cloud.hpp"

#include <gtest/gtest.h>

namespace cairn::geometry {
namespace {

PointCloud sample() {
  PointCloud cloud;
  cloud.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  cloud.colours = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
  cloud.add_scalar("target_id", ScalarType::u32, "target").values = {10, 11, 12};
  return cloud;
}

TEST(PointCloud, SubsetKeepsAllColumnsInTheGivenOrder) {
  const PointCloud part = sample().subset({2, 0});
  EXPECT_TRUE(part.consistent());
  ASSERT_EQ(part.size(), 2U);
  EXPECT_EQ(part.positions[0].x(), 2.0);
  EXPECT_EQ(part.colours[0][0], 7);
  ASSERT_NE(part.scalar("target_id"), nullptr);
  EXPECT_EQ(part.scalar("target_id")->values[1], 10.0);
  EXPECT_TRUE(part.normals.empty());
}

TEST(PointCloud, AddScalarReplacesTheSameName) {
  PointCloud cloud = sample();
  cloud.add_scalar("target_id", ScalarType::u16, "");
  EXPECT_EQ(cloud.scalars.size(), 1U);
  EXPECT_EQ(cloud.scalars[0].values, (std::vector<double>{0, 0, 0}));
}

TEST(PointCloud, InconsistentColumnsAreFound) {
  PointCloud cloud = sample();
  cloud.colours.pop_back();
  EXPECT_FALSE(cloud.consistent());
}

}  // namespace
}  // namespace cairn::geometry
