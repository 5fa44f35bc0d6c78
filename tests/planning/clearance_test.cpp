#include "planning/clearance.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.hpp"
#include "base/random.hpp"
#include "planning/trajectory.hpp"
#include "support/meshes.hpp"

namespace {

using cairn::geometry::Vec2;
using cairn::geometry::Vec3;
using cairn::planning::ClearanceOptions;
using cairn::planning::safe_leg;
using cairn::planning::SurfaceHeights;

// Level ground with a wall of 6 m across the way, known from -20 to 20 m.
SurfaceHeights wall() {
  cairn::geometry::Grid<float> up({-20, 20, 0.5, 80, 80}, 0.0F);
  for (std::size_t r = 0; r < 80; ++r)
    for (std::size_t c = 0; c < 80; ++c)
      if (std::abs(up.geometry.centre(r, c).x()) < 1.0) up.at(r, c) = 6.0F;
  return SurfaceHeights(up);
}

TEST(SurfaceHeights, HighestOfAMeshIsNeverBelowIt) {
  const auto mesh = cairn::testing::joined(cairn::testing::slab(-10, -10, 10, 10, 1.0, 20),
                                           cairn::testing::sphere(Vec3(2.3, -1.2, 3.0), 1.7, 24));
  const SurfaceHeights heights(cairn::planning::highest_of(mesh, 0.25));
  double worst = 0.0;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const Vec3 c = mesh.centroid(f);
    const auto up = heights.up(c.head<2>());
    ASSERT_TRUE(up.has_value());
    EXPECT_GE(*up, c.z() - 1e-5);
  }
  cairn::base::Random random(2, "heights", 0);
  for (int i = 0; i < 2000; ++i) {
    const Vec2 p(random.uniform(-9, 9), random.uniform(-9, 9));
    const double from_axis = (p - Vec2(2.3, -1.2)).norm();
    if (from_axis > 1.4 && from_axis < 1.9) continue;  // the rim is as steep as a wall
    const double truth = from_axis < 1.7 ? 3.0 + std::sqrt(1.7 * 1.7 - from_axis * from_axis) : 1.0;
    worst = std::max(worst, *heights.up(p) - truth);
  }
  EXPECT_LT(worst, 0.5);  // m: what a sphere rises within a cell of 0.25 m
  EXPECT_NEAR(heights.highest(), 4.7, 0.02);
  EXPECT_FALSE(heights.up(Vec2(30, 0)).has_value());
  EXPECT_THROW(static_cast<void>(cairn::planning::highest_of({}, 0.25)), cairn::base::Error);
}

TEST(SafeLeg, GoesStraightOrOver) {
  const ClearanceOptions options;
  EXPECT_TRUE(safe_leg(Vec3(-10, 0, 9.5), Vec3(10, 0, 9.5), wall(), options).empty());
  EXPECT_TRUE(safe_leg(Vec3(-10, 0, 4), Vec3(-5, 8, 4), wall(), options).empty());
  const auto over = safe_leg(Vec3(-10, 0, 4), Vec3(10, 3, 5), wall(), options);
  ASSERT_EQ(over.size(), 2U);
  EXPECT_LT((over[0] - Vec3(-10, 0, 9)).norm(), 1e-9);
  EXPECT_LT((over[1] - Vec3(10, 3, 9)).norm(), 1e-9);
  // Level after one climb where the goal lies high enough.
  EXPECT_EQ(safe_leg(Vec3(-10, 0, 4), Vec3(10, 3, 12), wall(), options).size(), 1U);
  EXPECT_TRUE(safe_leg(Vec3(5, 5, 4), Vec3(5, 5, 12), wall(), options).empty());
}

TEST(SafeLeg, KeepsItsClearanceOverRandomGround) {
  cairn::base::Random random(4, "ground", 0);
  cairn::geometry::Grid<float> up({-30, 30, 0.5, 120, 120}, 0.0F);
  for (float& v : up.values) v = random.uniform() < 0.03 ? static_cast<float>(random.uniform(0, 9)) : 0.0F;
  const SurfaceHeights ground(up);
  const ClearanceOptions options;
  for (int i = 0; i < 60; ++i) {
    const auto end = [&] {
      const Vec2 p(random.uniform(-25, 25), random.uniform(-25, 25));
      return Vec3(p.x(), p.y(), *cairn::planning::least_up(p, ground, options) + random.uniform(0, 2));
    };
    const Vec3 a = end(), b = end();
    auto path = safe_leg(a, b, ground, options);
    path.insert(path.begin(), a);
    path.push_back(b);
    std::vector<cairn::planning::FlightKey> keys;
    for (const Vec3& p : path) {
      keys.emplace_back();
      keys.back().pose << p, 0.0;
      keys.back().stop = true;
    }
    const auto flight = cairn::planning::plan_flight(keys, {});
    const auto least = cairn::planning::least_clearance(flight.trajectory, ground, options.clearance_radius_m, 0.1);
    EXPECT_GE(least.height_m, options.clearance_m - 1e-6) << i;
    EXPECT_EQ(least.unknown, 0U);
  }
}

TEST(LeastUp, LooksOverTheEdgeOfKnownGround) {
  const ClearanceOptions options;
  EXPECT_NEAR(*cairn::planning::least_up(Vec2(25, 0), wall(), options), 3.0, 1e-9);
  EXPECT_NEAR(*cairn::planning::least_up(Vec2(1.8, 0), wall(), options), 9.0, 1e-9);
  EXPECT_FALSE(cairn::planning::least_up(Vec2(35, 0), wall(), options).has_value());
}

}  // namespace
