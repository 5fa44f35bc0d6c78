#include "ground/image_footprint.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.hpp"
#include "support/ground_views.hpp"

namespace cairn::ground {
namespace {

using cairn::testing::board_camera;
using cairn::testing::frame_looking;
using geometry::Ring;
using geometry::Vec2;
using geometry::Vec3;

TEST(IsSimple, TellsABowTie) {
  EXPECT_TRUE(is_simple({{0, 0}, {1, 0}, {1, 1}, {0, 1}}));
  EXPECT_FALSE(is_simple({{0, 0}, {1, 1}, {1, 0}, {0, 1}}));
  EXPECT_FALSE(is_simple({{0, 0}, {1, 1}}));
}

TEST(DepthInside, IsTheDistanceToTheBorder) {
  const Ring square{{0, 0}, {4, 0}, {4, 4}, {0, 4}};
  EXPECT_DOUBLE_EQ(depth_inside(square, {1, 2}), 1.0);
  EXPECT_DOUBLE_EQ(depth_inside(square, {-3, 2}), -3.0);
  EXPECT_LT(depth_inside({}, {0, 0}), 0.0);
}

TEST(ImageFootprint, OfANadirImageIsItsRectangle) {
  const auto camera = board_camera();
  const auto frame = frame_looking(Vec3(5, 7, 12), Vec3(5, 7, 0));
  const auto ring = image_footprint(camera, frame.T_world_camera, {});
  EXPECT_NEAR(geometry::signed_area(ring), (12.0 * 1280 / 960) * (12.0 * 720 / 960), 1e-6);
  EXPECT_TRUE(geometry::contains(ring, {5, 7}));
}

// Whatever the attitude, horizon in the image or not: a simple ring, and what lies deep inside is in the image.
TEST(ImageFootprint, IsSimpleAndTrueForAnyAttitude) {
  const auto camera = board_camera();
  base::Random random(1, "footprint", 0);
  const GroundHeight hills = [](double e, double n) {
    return std::optional<double>(1.5 * std::sin(0.3 * e) * std::cos(0.2 * n));
  };
  int with_ground = 0;
  for (int trial = 0; trial < 300; ++trial) {
    auto frame = frame_looking(Vec3(0, 0, random.uniform(5, 15)),
                               Vec3(random.uniform(-40, 40), random.uniform(-40, 40), random.uniform(-20, 15)));
    frame.T_world_camera.rotation =
        frame.T_world_camera.rotation * geometry::axis_rotation(Vec3::UnitZ(), random.uniform(-3, 3));
    const bool rough = trial % 3 == 0;
    const auto ring = image_footprint(camera, frame.T_world_camera, {rough ? hills : GroundHeight{}, 0.0}, 60.0);
    if (ring.empty()) continue;
    ++with_ground;
    ASSERT_TRUE(is_simple(ring)) << trial;
    EXPECT_GT(geometry::signed_area(ring), 0.0);
    if (rough) continue;
    for (int i = 0; i < 50; ++i) {
      const Vec2 p(random.uniform(-60, 60), random.uniform(-60, 60));
      if (depth_inside(ring, p) < 0.01) continue;
      const auto pixel = camera::project_world(camera, frame.T_world_camera, Vec3(p.x(), p.y(), 0.0));
      ASSERT_TRUE(pixel) << trial;
      EXPECT_TRUE(camera::inside_image(camera, *pixel)) << trial;
    }
  }
  EXPECT_GT(with_ground, 150);
}

TEST(ImageFootprint, OfTheSkyIsEmpty) {
  const auto camera = board_camera();
  EXPECT_TRUE(image_footprint(camera, frame_looking(Vec3(0, 0, 10), Vec3(0, 50, 60)).T_world_camera, {}).empty());
}

}  // namespace
}  // namespace cairn::ground
