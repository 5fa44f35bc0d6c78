#include "planning/lawnmower.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.hpp"
#include "base/random.hpp"
#include "camera/projection.hpp"

namespace {

using cairn::geometry::Vec2;
using cairn::geometry::Vec3;
using cairn::planning::Area;
using cairn::planning::LawnmowerOptions;
using cairn::planning::plan_lawnmower;
using cairn::planning::SurfaceHeights;
using ::testing::HasSubstr;

cairn::survey::Camera camera() {
  cairn::survey::Camera c;
  c.id = cairn::survey::CameraId(1);
  c.width_px = 4000;
  c.height_px = 3000;
  c.fx_px = c.fy_px = 3000;
  c.cx_px = 2000;
  c.cy_px = 1500;
  return c;
}

// A star of random radii about the origin: never crosses itself.
Area star(std::uint64_t record, double size) {
  cairn::base::Random random(7, "area", record);
  cairn::geometry::Ring ring;
  const auto n = static_cast<int>(5 + random.below(8));
  for (int i = 0; i < n; ++i) {
    const double a = 6.283185307179586 * i / n, r = size * random.uniform(0.35, 1.0);
    ring.emplace_back(r * std::cos(a), r * std::sin(a));
  }
  return {ring};
}

// Views of a point of the plane z = up, counted one by one.
std::size_t views_of(const cairn::planning::LawnmowerPlan& plan, const Vec2& p, double up) {
  std::size_t n = 0;
  for (const auto& view : plan.views) {
    const auto pixel = cairn::camera::project_world(camera(), view.T_world_camera, Vec3(p.x(), p.y(), up));
    if (pixel && cairn::camera::inside_image(camera(), *pixel)) ++n;
  }
  return n;
}

TEST(Lawnmower, LeavesNoStripAndKeepsTheOverlapUpToTheBorder) {
  cairn::base::RunContext ctx;
  for (std::uint64_t run = 0; run < 12; ++run) {
    cairn::base::Random random(8, "lawnmower", run);
    LawnmowerOptions options;
    options.gsd_m = random.uniform(0.005, 0.012);
    options.front_overlap = random.uniform(0.2, 0.85);
    options.side_overlap = random.uniform(0.2, 0.8);
    options.pitch_deg = run % 3 == 0 ? -60.0 : -90.0;
    options.cross_hatch = run % 4 == 1;
    options.heading = run % 2 == 0 ? "lane" : "fixed";
    const Area area = star(run, 40.0);
    const SurfaceHeights ground(3.0);
    const auto plan = plan_lawnmower(area, camera(), ground, options, ctx);
    EXPECT_EQ(plan.overlap.uncovered, 0U);
    EXPECT_GE(plan.overlap.first_percentile, plan.wanted_views);
    std::size_t tested = 0;
    for (int i = 0; i < 400; ++i) {
      const Vec2 p(random.uniform(-40, 40), random.uniform(-40, 40));
      if (!cairn::planning::inside(area, p)) continue;
      EXPECT_GE(views_of(plan, p, 3.0), plan.wanted_views) << "run " << run << " at " << p.transpose();
      ++tested;
    }
    EXPECT_GT(tested, 20U);
    EXPECT_EQ(plan.views.size(), plan.view_waypoint.size());
  }
}

// Nadir over level ground: all follows from the field of view.
TEST(Lawnmower, SpacingFollowsFromOverlapAndSamplingDistance) {
  cairn::base::RunContext ctx;
  LawnmowerOptions options;
  options.gsd_m = 0.01;
  const Area area{{{0, 0}, {200, 0}, {200, 90}, {0, 90}}};
  const auto plan = plan_lawnmower(area, camera(), SurfaceHeights(0.0), options, ctx);
  EXPECT_NEAR(plan.height_m, 30.0, 1e-9);
  EXPECT_NEAR(plan.footprint_across_m, 40.0, 1e-6);
  EXPECT_NEAR(plan.footprint_along_m, 30.0, 1e-6);
  EXPECT_NEAR(plan.image_spacing_m, 6.0, 1e-6);
  EXPECT_NEAR(plan.lane_spacing_m, 12.0, 1e-6);
  // Lanes along the long side; 90 m + 2 (20 - 12) m of them at 12 m.
  EXPECT_EQ(plan.lanes, 10U);
  for (const auto& w : plan.waypoints) {
    EXPECT_NEAR(w.position.z(), 30.0, 1e-9);
    EXPECT_NEAR(std::abs(std::remainder(w.heading_deg, 180.0)), 90.0, 1e-6);
  }
  EXPECT_NEAR(plan.overlap.coarsest_gsd_m, 0.01, 1e-9);
}

// A hill of 12 m in the middle: the level flight comes closer to it, the other follows it.
TEST(Lawnmower, KeepsTheOverlapOverAHill) {
  cairn::base::RunContext ctx;
  cairn::geometry::Grid<float> up({-80, 80, 1.0, 160, 160}, 0.0F);
  for (std::size_t r = 0; r < 160; ++r)
    for (std::size_t c = 0; c < 160; ++c)
      up.at(r, c) = static_cast<float>(12.0 * std::exp(-up.geometry.centre(r, c).squaredNorm() / 800.0));
  const SurfaceHeights hill(up);
  const Area area{{{-60, -60}, {60, -60}, {60, 60}, {-60, 60}}};
  LawnmowerOptions options;
  options.height_m = 30.0;
  const auto level = plan_lawnmower(area, camera(), hill, options, ctx);
  EXPECT_EQ(level.overlap.uncovered, 0U);
  EXPECT_GE(level.overlap.first_percentile, level.wanted_views);
  options.follow_terrain = true;
  const auto follow = plan_lawnmower(area, camera(), hill, options, ctx);
  EXPECT_EQ(follow.overlap.uncovered, 0U);
  EXPECT_GE(follow.overlap.first_percentile, follow.wanted_views);
  double least = 1e9, most = 0.0;
  for (const auto& view : follow.views) {
    const Vec3 at = view.T_world_camera.translation;
    const auto below = hill.up(at.head<2>());
    if (!below) continue;
    least = std::min(least, at.z() - *below);
    most = std::max(most, at.z() - *below);
  }
  EXPECT_GT(least, 27.0);
  EXPECT_LT(most, 36.0);
  EXPECT_LT(follow.views.size(), level.views.size());
}

TEST(Lawnmower, StaysClearOfATower) {
  cairn::base::RunContext ctx;
  cairn::geometry::Grid<float> up({-50, 50, 1.0, 100, 100}, 0.0F);
  up.at(40, 60) = 34.0F;
  const SurfaceHeights tower(up);
  LawnmowerOptions options;
  options.height_m = 30.0;
  const Area area{{{-40, -40}, {40, -40}, {40, 40}, {-40, 40}}};
  const auto plan = plan_lawnmower(area, camera(), tower, options, ctx);
  for (const auto& w : plan.waypoints) EXPECT_GE(w.position.z(), 39.0);
  ASSERT_FALSE(plan.notes.empty());
  EXPECT_THAT(plan.notes.front(), HasSubstr("above the highest point"));
}

TEST(Lawnmower, RefusesWhatCannotBePlanned) {
  cairn::base::RunContext ctx;
  const Area area{{{0, 0}, {50, 0}, {50, 50}, {0, 50}}};
  LawnmowerOptions options;
  EXPECT_THROW(static_cast<void>(plan_lawnmower(area, camera(), SurfaceHeights(0.0), options, ctx)),
               cairn::base::Error);
  options.gsd_m = 0.01;
  options.height_m = 20.0;
  EXPECT_THROW(static_cast<void>(plan_lawnmower(area, camera(), SurfaceHeights(0.0), options, ctx)),
               cairn::base::Error);
  options.height_m = 0.0;
  EXPECT_THROW(static_cast<void>(
                   plan_lawnmower({{{0, 0}, {50, 50}, {50, 0}, {0, 50}}}, camera(), SurfaceHeights(0.0), options, ctx)),
               cairn::base::Error);
  cairn::geometry::Grid<float> elsewhere({500, 500, 1.0, 10, 10}, 0.0F);
  EXPECT_THROW(static_cast<void>(plan_lawnmower(area, camera(), SurfaceHeights(elsewhere), options, ctx)),
               cairn::base::Error);
}

}  // namespace
