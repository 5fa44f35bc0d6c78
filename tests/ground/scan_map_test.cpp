#include "ground/scan_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "base/error.hpp"
#include "base/random.hpp"
#include "ground/live_costmap.hpp"

namespace cairn::ground {
namespace {

using geometry::GridGeometry;
using geometry::Pose2;
using geometry::Vec2;
constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
const GridGeometry kField{-10.0, 10.0, 0.1, 200, 200};

survey::RangeScan scan_of(std::vector<float> ranges, double angle_min = 0.0, double increment = 0.01) {
  survey::RangeScan scan;
  scan.angle_min = angle_min;
  scan.angle_increment = increment;
  scan.range_min_m = 0.1;
  scan.range_max_m = 30.0;
  scan.ranges = std::move(ranges);
  return scan;
}

Occupancy at(const ScanMap& map, double east, double north) {
  const auto cell = map.grid().geometry.cell_at({east, north});
  return map.grid().at(cell->first, cell->second);
}

TEST(ScanMap, MarksTheEndAndFreesTheWay) {
  ScanMap map(kField, {});
  // Facing north from (1, 1): a wall 3 m ahead.
  const CellRegion changed = map.add(scan_of({3.0F}), Pose2{{1.05, 1.05}, 0.5 * std::numbers::pi});
  EXPECT_EQ(at(map, 1.05, 4.05), Occupancy::occupied);
  EXPECT_EQ(at(map, 1.05, 3.95), Occupancy::free);
  EXPECT_EQ(at(map, 1.05, 1.05), Occupancy::free);
  EXPECT_EQ(at(map, 1.05, 4.15), Occupancy::unknown);
  EXPECT_EQ(at(map, 1.25, 3.0), Occupancy::unknown);
  EXPECT_EQ(changed.columns, 1U);
  EXPECT_EQ(changed.rows, 31U);
  EXPECT_EQ(map.counts().marked, 1U);
}

TEST(ScanMap, RangeGatesAsRep117) {
  ScanMapOptions options;
  options.obstacle_range_m = 5.0;
  options.clear_range_m = 6.0;
  const double east = 0.0;
  const auto one = [&](float range) {
    ScanMap map(kField, options);
    map.add(scan_of({range}), Pose2{{0.05, 0.05}, east});
    return map;
  };
  const auto nothing = one(kNan);
  EXPECT_EQ(nothing.counts().no_measurement, 1U);
  EXPECT_EQ(at(nothing, 1.0, 0.05), Occupancy::unknown);
  const auto near = one(-kInf);
  EXPECT_EQ(near.counts().too_near, 1U);
  EXPECT_EQ(at(near, 1.0, 0.05), Occupancy::unknown);
  EXPECT_EQ(one(0.15F).counts().too_near, 1U) << "min_range_m of 0.2";
  const auto open = one(kInf);
  EXPECT_EQ(at(open, 5.9, 0.05), Occupancy::free);
  EXPECT_EQ(at(open, 6.15, 0.05), Occupancy::unknown);
  const auto beyond = one(5.5F);
  EXPECT_EQ(beyond.counts().cleared_only, 1U);
  EXPECT_EQ(at(beyond, 5.3, 0.05), Occupancy::free);
  EXPECT_EQ(at(beyond, 5.55, 0.05), Occupancy::unknown) << "something stands there";
  EXPECT_EQ(one(31.0F).counts().too_far, 1U);
  options.infinite_clears = false;
  EXPECT_EQ(one(kInf).counts().no_measurement, 1U);
}

TEST(ScanMap, WhatIsGoneIsClearedAfterSomeScans) {
  ScanMapOptions options;
  ScanMap map(kField, options);
  const Pose2 pose{{0.05, 0.05}, 0.0};
  for (int i = 0; i < 10; ++i) map.add(scan_of({2.0F}), pose);
  int scans = 0;
  while (at(map, 2.05, 0.05) == Occupancy::occupied && scans < 100) {
    map.add(scan_of({5.0F}), pose);
    ++scans;
  }
  EXPECT_EQ(scans, options.limit / options.pass);
  map.add(scan_of({5.0F}), pose);
  EXPECT_EQ(at(map, 2.05, 0.05), Occupancy::free);
}

TEST(ScanMap, OneScanDoesNotClearWhatItHit) {
  ScanMap map(kField, {});
  // Rays that graze past a corner: the second ray passes through the cell that the first one hit.
  map.add(scan_of({2.0F, 4.0F, 4.0F, 4.0F}, 0.0, 0.005), Pose2{{0.05, 0.05}, 0.0});
  EXPECT_EQ(at(map, 2.05, 0.05), Occupancy::occupied);
}

// Each ray against a dense sampling of its line.
TEST(ScanMap, ClearsEveryCellOfARayAndNoOther) {
  base::Random random(1, "scan", 0);
  for (int trial = 0; trial < 200; ++trial) {
    ScanMapOptions options;
    options.clear_range_m = 100.0;
    options.obstacle_range_m = 100.0;
    ScanMap map({-2.0, 2.0, 0.1, 40, 40}, options);
    const Pose2 pose{{random.uniform(-4.0, 4.0), random.uniform(-4.0, 4.0)}, random.uniform(-3.1, 3.1)};
    const auto range = static_cast<float>(random.uniform(0.3, 6.0));
    map.add(scan_of({range}), pose);
    const Vec2 direction(std::cos(pose.yaw), std::sin(pose.yaw));
    const auto& g = map.grid().geometry;
    std::vector<char> on_line(g.cells(), 0);
    constexpr double kStep = 0.001;    // m
    constexpr double kCorner = 0.003;  // m; a cell cut by less than this may be missed by the sampling
    for (double s = 0.0; s <= static_cast<double>(range); s += kStep)
      if (const auto cell = g.cell_at(pose.position + s * direction)) {
        on_line[cell->first * g.columns + cell->second] = 1;
        const auto value = map.grid().at(cell->first, cell->second);
        ASSERT_NE(value, Occupancy::unknown) << "trial " << trial << " at " << s;
      }
    for (std::size_t r = 0; r < g.rows; ++r)
      for (std::size_t c = 0; c < g.columns; ++c) {
        if (map.grid().at(r, c) == Occupancy::unknown || on_line[r * g.columns + c] != 0) continue;
        const Vec2 d = g.centre(r, c) - pose.position;
        const double aside = std::abs(d.x() * direction.y() - d.y() * direction.x());
        ASSERT_GT(aside, 0.5 * g.cell - kCorner) << "trial " << trial;
        ASSERT_LT(aside, std::sqrt(0.5) * g.cell + 1e-9) << "trial " << trial;
      }
  }
}

TEST(ScanMap, DeskewsATurningVehicle) {
  // 100 rays in 0.1 s while the vehicle turns at 2 rad/s and drives at 1 m/s along x. A wall at y = 3.
  const auto pose_at = [](std::int64_t t) {
    const double s = static_cast<double>(t) * 1e-9;
    return std::optional(Pose2{{1.0 * s, 0.0}, 2.0 * s});
  };
  survey::RangeScan scan = scan_of({}, 0.8, 0.015);
  scan.time_increment_ns = 1'000'000;
  for (int i = 0; i < 100; ++i) {
    const auto pose = pose_at(i * scan.time_increment_ns);
    const double angle = pose->yaw + 0.8 + i * 0.015;
    scan.ranges.push_back(static_cast<float>(3.04 / std::sin(angle)));
  }
  const auto wall = [](const ScanMap& map) {
    std::size_t on = 0, off = 0;
    for (std::size_t r = 0; r < map.grid().geometry.rows; ++r)
      for (std::size_t c = 0; c < map.grid().geometry.columns; ++c)
        if (map.grid().at(r, c) == Occupancy::occupied)
          ++(std::abs(map.grid().geometry.centre(r, c).y() - 3.05) < 0.01 ? on : off);
    return std::pair(on, off);
  };
  ScanMap deskewed(kField, {}), skewed(kField, {});
  deskewed.add(scan, pose_at);
  skewed.add(scan, *pose_at(0));
  EXPECT_GT(wall(deskewed).first, 30U);
  EXPECT_EQ(wall(deskewed).second, 0U);
  EXPECT_GT(wall(skewed).second, 10U) << "without deskew the wall would be bent";
}

TEST(ScanMap, SensorStandsWhereItIsMounted) {
  ScanMapOptions options;
  options.sensor_forward_m = 1.0;
  options.sensor_left_m = 0.5;
  options.sensor_yaw_deg = 90.0;
  ScanMap map(kField, options);
  map.add(scan_of({2.0F}), Pose2{{0.05, 0.05}, 0.0});
  EXPECT_EQ(at(map, 1.05, 2.55), Occupancy::occupied);
}

TEST(ScanMap, BadScans) {
  ScanMap map(kField, {});
  const Pose2 pose;
  auto scan = scan_of({1.0F});
  scan.angle_increment = 0.0;
  EXPECT_THROW(map.add(scan, pose), base::Error);
  scan = scan_of({1.0F});
  scan.range_max_m = 0.05;
  EXPECT_THROW(map.add(scan, pose), base::Error);
  scan = scan_of({1.0F});
  scan.angle_min = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(map.add(scan, pose), base::Error);
  map.add(scan_of({1.0F, 2.0F}), [](std::int64_t) { return std::optional<Pose2>(); });
  EXPECT_EQ(map.counts().without_pose, 2U);
  EXPECT_TRUE(map.add(scan_of({1.0F}), Pose2{{1e12, 0.0}, 0.0}).empty());
}

TEST(LiveCostmap, FollowsObstaclesAndScansToTheByte) {
  base::Random random(5, "live", 0);
  OccupancyGrid prior({0.0, 12.0, 0.05, 240, 240}, Occupancy::free);
  for (std::size_t c = 0; c < 240; ++c) prior.at(0, c) = Occupancy::occupied;
  for (std::size_t r = 100; r < 140; ++r)
    for (std::size_t c = 0; c < 40; ++c) prior.at(r, c) = Occupancy::unknown;
  LiveCostmap live(prior, {});
  EXPECT_TRUE(live.update().empty());
  for (int tick = 0; tick < 15; ++tick) {
    std::vector<survey::Obstacle> obstacles(3);
    for (auto& o : obstacles) {
      o.position = {random.uniform(-1.0, 13.0), random.uniform(-1.0, 13.0), 0.0};
      o.width_m = random.uniform(0.0, 0.8);
    }
    if (tick % 3 != 1) live.set_obstacles(obstacles);
    std::vector<float> ranges(90);
    for (auto& r : ranges) r = static_cast<float>(random.uniform(0.5, 6.0));
    live.add_scan(scan_of(std::move(ranges), 0.0, 0.07), [&](std::int64_t) {
      return std::optional(Pose2{{6.0, 6.0}, 0.3 * tick});
    });
    EXPECT_FALSE(live.update().empty());
    ASSERT_EQ(live.cost().values, costmap(live.occupancy(), {}).values) << tick;
    if (tick % 3 == 1) continue;
    OccupancyGrid marks(prior.geometry, Occupancy::unknown), whole_map(prior.geometry, Occupancy::unknown);
    (void)mark_obstacles(obstacles, marks);
    combine(prior, &marks, &live.scans().grid(), {}, whole(prior.geometry), whole_map);
    ASSERT_EQ(live.occupancy().values, whole_map.values) << tick;
  }
}

}  // namespace
}  // namespace cairn::ground
