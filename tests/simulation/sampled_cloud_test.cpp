#include "simulation/sampled_cloud.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "simulation/shape.hpp"
#include "support/meshes.hpp"

namespace cairn::simulation {
namespace {

using geometry::Vec3;

constexpr double kNoTarget = 4294967295.0;

struct World {
  Shape rock;
  RenderScene scene;
};

World world() {
  ShapeSpec spec;
  spec.family = "pear";
  spec.size_m = Vec3(1.2, 1.0, 1.4);
  spec.pedestal_height_m = 0.5;
  spec.contact_share = 0.4;
  base::Random random(2, "cloud_test", 0);
  Shape rock = make_shape(spec, random);
  std::vector<RenderBody> bodies(3);
  bodies[0].mesh = testing::slab(-4.0, -4.0, 4.0, 4.0, 0.0, 16);
  bodies[0].part = SurfacePart::terrain;
  bodies[1].mesh = rock.pedestal;
  bodies[1].part = SurfacePart::pedestal;
  bodies[1].object = 12;
  bodies[2].mesh = rock.body;
  bodies[2].part = SurfacePart::rock;
  bodies[2].object = 12;
  bodies[2].contact_rim = rock.contact_rim;
  Lighting light;
  light.openness_rays = 4;
  return {std::move(rock), RenderScene(std::move(bodies), light)};
}

CloudOptions exact() {
  CloudOptions options;
  options.spacing_m = 0.03;
  options.noise_m = 0.0;
  return options;
}

double nearest_on_rim(const std::vector<Vec3>& ring, const Vec3& p) {
  double best = 1e300;
  for (const Vec3& q : ring) best = std::min(best, (p - q).norm());
  return best;
}

TEST(SampledCloud, LabelsAreThoseOfTheSurfaces) {
  const World w = world();
  base::RunContext ctx;
  const auto cloud = sample_cloud(w.scene, {}, exact(), ctx);
  ASSERT_TRUE(cloud.consistent());
  const auto& label = cloud.scalar("label")->values;
  const auto& target = cloud.scalar("target_id")->values;
  std::array<std::size_t, 5> count{};
  const auto rim = w.rock.contact_rim.front();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vec3& p = cloud.positions[i];
    ++count[static_cast<std::size_t>(label[i])];
    EXPECT_EQ(target[i], label[i] == 1.0 ? kNoTarget : 12.0);
    if (label[i] == 1.0) {
      EXPECT_NEAR(p.z(), 0.0, 1e-9);
    }
    // Buried flanks of the pedestal, its hidden top and the rock's underside are no surface of the scene.
    EXPECT_GT(p.z(), -1e-9);
    // The ring's own points are 0.03 m apart at most: half of that.
    const double reach = 1.5 * 0.03;
    if (label[i] == 4.0) {
      EXPECT_LT(nearest_on_rim(rim, p), reach + 0.015);
    }
    if (label[i] == 2.0 || label[i] == 3.0) {
      EXPECT_GT(nearest_on_rim(rim, p), reach - 1e-9);
    }
  }
  EXPECT_EQ(count[0], 0U);
  for (std::size_t k = 1; k < 5; ++k) EXPECT_GT(count[k], 100U) << k;
  // A plane of level ground: one point in nearly each square of the spacing.
  const double squares = 64.0 / (0.03 * 0.03);
  EXPECT_NEAR(static_cast<double>(count[1]) / squares, 0.95, 0.07);
}

TEST(SampledCloud, ViewsSeeOnlyTheirSide) {
  const World w = world();
  View view;
  view.camera.width_px = view.camera.height_px = 800;
  view.camera.fx_px = view.camera.fy_px = 800.0;
  view.camera.cx_px = view.camera.cy_px = 400.0;
  // From the east, level: camera z = west, x = north.
  view.T_world_camera.rotation << 0, 0, -1, 1, 0, 0, 0, -1, 0;
  view.T_world_camera.translation = Vec3(6.0, 0.0, 1.0);
  base::RunContext ctx;
  CloudOptions options = exact();
  options.min_views = 1;
  const std::vector<View> views = {view};
  const auto cloud = sample_cloud(w.scene, views, options, ctx);
  const auto& label = cloud.scalar("label")->values;
  std::size_t rock = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (label[i] != 2.0) continue;
    ++rock;
    EXPECT_GT(cloud.positions[i].x(), w.rock.body.bounds().min.x() + 0.2);
  }
  EXPECT_GT(rock, 300U);
  options.min_views = 2;
  EXPECT_TRUE(sample_cloud(w.scene, views, options, ctx).empty());
}

TEST(SampledCloud, NoiseIsTheOneAskedForAndAlongTheNormal) {
  const World w = world();
  base::RunContext ctx;
  CloudOptions options = exact();
  options.noise_m = 0.005;
  const auto cloud = sample_cloud(w.scene, {}, options, ctx);
  const auto& label = cloud.scalar("label")->values;
  double sum = 0.0, n = 0.0;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (label[i] == 1.0) {
      sum += cloud.positions[i].z() * cloud.positions[i].z();
      n += 1.0;
    }
  EXPECT_NEAR(std::sqrt(sum / n), 0.005, 0.0001);  // some 65 000 points: known to 0.3 %
}

TEST(SampledCloud, MarginKeepsThePointsNearTheRock) {
  const World w = world();
  base::RunContext ctx;
  CloudOptions options = exact();
  options.margin_m = 0.5;
  auto box = w.rock.pedestal.bounds();
  box.extend(w.rock.body.bounds().min);
  box.extend(w.rock.body.bounds().max);
  const auto cloud = sample_cloud(w.scene, {}, options, ctx);
  ASSERT_GT(cloud.size(), 1000U);
  for (const Vec3& p : cloud.positions)
    ASSERT_TRUE(p.x() >= box.min.x() - 0.5 && p.x() <= box.max.x() + 0.5 && p.y() >= box.min.y() - 0.5 &&
                p.y() <= box.max.y() + 0.5);
}

TEST(SampledCloud, SameBytesForAnyNumberOfThreadsAndOtherBytesForAnotherSeed) {
  const World w = world();
  CloudOptions options = exact();
  options.noise_m = 0.01;
  options.waviness_m = 0.01;
  const auto sampled = [&](int threads, std::uint64_t seed) {
    const base::ThreadLimit limit(threads);
    base::RunContext ctx;
    ctx.seed = seed;
    return sample_cloud(w.scene, {}, options, ctx);
  };
  const auto one = sampled(1, 4), four = sampled(4, 4), other = sampled(1, 5);
  EXPECT_EQ(one.positions, four.positions);
  EXPECT_EQ(one.colours, four.colours);
  EXPECT_NE(one.positions, other.positions);
}

TEST(SampledCloud, RefusesMoreThanMemoryHolds) {
  const World w = world();
  base::RunContext ctx;
  ctx.memory_limit_bytes = 1 << 20;
  EXPECT_THROW(static_cast<void>(sample_cloud(w.scene, {}, exact(), ctx)), base::Error);
  CloudOptions options = exact();
  options.spacing_m = 0.0;
  base::RunContext free;
  EXPECT_THROW(static_cast<void>(sample_cloud(w.scene, {}, options, free)), base::Error);
}

}  // namespace
}  // namespace cairn::simulation
