#include "coverage/visibility_query.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.hpp"
#include "support/meshes.hpp"
#include "support/views.hpp"

namespace cairn::coverage {
namespace {

using geometry::TriangleMesh;
using geometry::Vec3;

constexpr double kSingle = 1e-4;  // m: ranges are traced in single precision

TEST(WhoSees, SaysWhichFramesAndWhyNotTheOthers) {
  // A roof of 2 x 2 m, 5 m up, above the point.
  const TriangleMesh mesh = testing::joined(testing::slab(-20, -20, 20, 20, 0, 4), testing::slab(-1, -1, 1, 1, 5, 1));
  ViewSet views;
  views.cameras.push_back(testing::pinhole_camera(1000, 1000, 1000));
  testing::add_view(views, Vec3(0, 0, 20), Vec3(0, 0, 0));
  testing::add_view(views, Vec3(15, 0, 20), Vec3(0, 0, 0));
  testing::add_view(views, Vec3(15, 0, 20), Vec3(40, 0, 0));
  const auto rows = who_sees(Vec3(0, 0, 0), visibility::Scene(mesh), views, {});
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0].sight, Sight::occluded);
  EXPECT_NEAR(rows[0].blocked_at_m, 15.0, kSingle);
  EXPECT_NEAR(rows[0].pixel.x(), 500.0, 1e-9);
  EXPECT_EQ(rows[1].sight, Sight::seen);
  EXPECT_NEAR(rows[1].range_m, 25.0, 1e-12);
  EXPECT_NEAR(rows[1].gsd_mm, 25.0, 1e-9);
  EXPECT_TRUE(std::isnan(rows[1].blocked_at_m));
  EXPECT_EQ(rows[2].sight, Sight::out_of_frame);
  EXPECT_TRUE(std::isnan(rows[2].gsd_mm));
  EXPECT_EQ(rows[2].frame.value, 2);
  EXPECT_EQ(name_of(rows[0].sight), "occluded");
  EXPECT_THROW((void)who_sees(Vec3(std::nan(""), 0, 0), visibility::Scene(mesh), views, {}), base::Error);
}

TEST(Viewshed, OfAWallEndsAtItsShadow) {
  // A wall of 2 m at x = 5, the eye at 4 m height above x = 0: the shadow reaches from x = 5 to x = 10.
  const TriangleMesh ground = testing::slab(-20, -20, 20, 20, 0, 200);
  const TriangleMesh mesh = testing::joined(ground, testing::box(Vec3(5, -20, 0), Vec3(5.01, 20, 2)));
  const auto seen = viewshed(mesh, visibility::Scene(mesh), Vec3(0, 0, 4));
  for (std::size_t f = 0; f < ground.triangles.size(); ++f) {
    const double x = ground.centroid(f).x();
    const bool border = std::abs(x - 5.0) < 0.1 || std::abs(x - 10.02) < 0.1;
    if (!border) {
      ASSERT_EQ(seen[f], x < 5.0 || x > 10.0 ? 1 : 0) << x;
    }
  }
  // Nothing is seen from below, nor from nowhere.
  for (const auto flag : viewshed(ground, visibility::Scene(ground), Vec3(0, 0, -1))) EXPECT_EQ(flag, 0);
  for (const auto flag : viewshed(ground, visibility::Scene(ground), Vec3(0, std::nan(""), 1))) EXPECT_EQ(flag, 0);
}

}  // namespace
}  // namespace cairn::coverage
