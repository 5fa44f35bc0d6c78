// Poses of a metre and a few degrees over a ground with relief, tracks exact: how far do they come together?
#include "adjustment/rough_alignment.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "adjustment/robust.hpp"
#include "base/angle.hpp"
#include "base/random.hpp"

namespace cairn::adjustment {
namespace {

using geometry::Mat3;
using geometry::Vec2;
using geometry::Vec3;

// Two legs of five nadir views at 40 m, 12 m apart, the second flown back.
struct Block {
  std::vector<RoughCamera> truth;
  std::vector<RayTrack> tracks;
};

Block block() {
  Block result;
  Mat3 down;
  down << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  for (int leg = 0; leg < 2; ++leg)
    for (int i = 0; i < 5; ++i) {
      RoughCamera camera;
      camera.T_world_camera.translation = Vec3(12.0 * i, 18.0 * leg, 40.0 + 0.3 * i);
      camera.T_world_camera.rotation =
          geometry::axis_rotation(Vec3::UnitZ(), leg == 0 ? 0.05 * i : base::deg_to_rad(180.0)) * down;
      result.truth.push_back(camera);
    }
  for (int i = 0; i < 40; ++i)
    for (int j = 0; j < 20; ++j) {
      const Vec3 p(-10.0 + 2.0 * i, -8.0 + 2.0 * j, 1.5 * std::sin(0.7 * i) + std::cos(1.1 * j));
      RayTrack track;
      for (std::size_t c = 0; c < result.truth.size(); ++c) {
        const Vec3 at = result.truth[c].T_world_camera.inverse() * p;
        const Vec2 seen = at.head<2>() / at.z();
        constexpr double kHalfWidth = 0.87, kHalfHeight = 0.49;  // of a 1600 x 900 image at 914 px
        if (std::abs(seen.x()) < kHalfWidth && std::abs(seen.y()) < kHalfHeight) track.rays.push_back({c, seen});
      }
      if (track.rays.size() >= 2) result.tracks.push_back(track);
    }
  return result;
}

std::vector<RoughCamera> disturbed(std::vector<RoughCamera> cameras) {
  base::Random random(7, "disturb", 0);
  for (auto& camera : cameras) {
    auto& T = camera.T_world_camera;
    const auto spread = [&](double sigma) { return sigma * random.normal(); };
    T.translation += Vec3(spread(1.0), spread(1.0), spread(1.5));
    T.rotation = geometry::axis_rotation(Vec3::UnitZ(), base::deg_to_rad(spread(3.0))) * T.rotation *
                 geometry::axis_rotation(Vec3::UnitX(), base::deg_to_rad(spread(1.5)));
  }
  return cameras;
}

constexpr double kFocalPx = 914.0;

TEST(RoughAlignment, BringsRoughPosesToAFewPixels) {
  auto b = block();
  auto cameras = disturbed(b.truth);
  std::vector<double> before;
  for (const auto& track : b.tracks)
    if (const auto p = intersect_rays(track.rays, cameras, 0.01))
      for (const auto& ray : track.rays) before.push_back(ray_residual(ray, cameras[ray.camera], *p) * kFocalPx);
  const double after = align_roughly(cameras, b.tracks, 0.0) * kFocalPx;
  EXPECT_GT(median(before), 15.0);
  constexpr double kGoodStartPx = 2.0;  // well inside the gate of the ties (0.004 focal lengths = 3.7 px)
  EXPECT_LT(after, kGoodStartPx);
}

TEST(RoughAlignment, LeavesTruePosesAlone) {
  auto b = block();
  auto cameras = b.truth;
  EXPECT_LT(align_roughly(cameras, b.tracks, std::nullopt), 1e-6);
  for (std::size_t i = 0; i < cameras.size(); ++i)
    EXPECT_LT((cameras[i].T_world_camera.translation - b.truth[i].T_world_camera.translation).norm(), 1e-3);
}

TEST(RoughAlignment, IntersectsExactRays) {
  const auto b = block();
  for (const auto& track : b.tracks) {
    const auto p = intersect_rays(track.rays, b.truth, 0.001);
    ASSERT_TRUE(p);
    for (const auto& ray : track.rays) EXPECT_LT(ray_residual(ray, b.truth[ray.camera], *p), 1e-9);
  }
}

TEST(RoughAlignment, ParallelRaysAndPointsBehindHaveNoIntersection) {
  std::vector<RoughCamera> cameras(2);
  cameras[1].T_world_camera.translation = Vec3(1.0, 0.0, 0.0);
  const std::vector<TrackRay> parallel{{0, Vec2(0.1, 0.0)}, {1, Vec2(0.1, 0.0)}};
  EXPECT_FALSE(intersect_rays(parallel, cameras, 0.01));
  const std::vector<TrackRay> diverging{{0, Vec2(-0.1, 0.0)}, {1, Vec2(0.1, 0.0)}};
  EXPECT_FALSE(intersect_rays(diverging, cameras, 0.01));
}

}  // namespace
}  // namespace cairn::adjustment
