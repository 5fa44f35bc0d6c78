#include "fragility/photo_view.hpp"

#include <gtest/gtest.h>

#include "base/angle.hpp"
#include "support/bodies.hpp"

namespace cairn::fragility {
namespace {

using namespace cairn::testing;
using base::deg_to_rad;

constexpr double kExact = 1e-9;

std::vector<Vec3> corners(double w, double d, double z) {
  return {{-w / 2, -d / 2, z}, {w / 2, -d / 2, z}, {w / 2, d / 2, z}, {-w / 2, d / 2, z}};
}

// A rectangle in every view: centroid at half the height, rocking points at the projected corners.
TEST(PhotoView, Block) {
  const double w = 1.0, d = 2.0, h = 3.0;
  const auto views = photo_views(block(w, d, h), corners(w, d, 0.0), 15.0, 16);
  ASSERT_EQ(views.size(), 12U);
  for (const auto& v : views) {
    const double a = deg_to_rad(v.view_azimuth_deg);
    const double half = 0.5 * (w * std::abs(std::cos(a)) + d * std::abs(std::sin(a)));
    EXPECT_NEAR(std::tan(v.alpha_left_rad), half / 1.5, kExact) << v.view_azimuth_deg;
    EXPECT_NEAR(std::tan(v.alpha_right_rad), half / 1.5, kExact) << v.view_azimuth_deg;
    EXPECT_NEAR(v.r_left_m, std::hypot(half, 1.5), kExact);
  }
  // Seen along north the block is 1 m wide: the alpha of its critical edge.
  EXPECT_NEAR(views[0].alpha_left_rad, std::atan(1.0 / 3.0), kExact);
}

TEST(PhotoView, LeftAndRightAsSeen) {
  // Looking north, right is east: the contact reaches 0.5 west and 0.2 east of the middle.
  const std::vector<Vec3> contact = {{-.5, 0, 0}, {.2, -.1, 0}, {.2, .1, 0.1}};
  const auto view = photo_views(block(1, 1, 3), contact, 180.0, 16).at(0);
  EXPECT_NEAR(std::tan(view.alpha_left_rad), 0.5 / 1.5, kExact);
  EXPECT_NEAR(std::tan(view.alpha_right_rad), 0.2 / 1.5, kExact);  // first of two ends equally far
}

// The silhouette's area centroid is not the volume's: a cone's is at H/3, its centre of mass at H/4.
TEST(PhotoView, ConeStandsHigherInAPhotograph) {
  const auto views = photo_views(frustum(0.5, 0.0, 2.0, 64), corners(1, 1, 0), 90.0, 400);
  constexpr double kSlices = 1e-4;  // midpoint rule, 400 slices
  EXPECT_NEAR(0.5 / std::tan(views[0].alpha_left_rad), 2.0 / 3.0, kSlices);
}

// Two lobes with air between them: the slice is the union of its pieces, counted once.
TEST(PhotoView, ForkedBody) {
  auto mesh = moved(block(0.4, 0.4, 2), Vec3(-0.5, 0, 0));
  const auto other = moved(block(0.4, 0.4, 1), Vec3(0.5, 0, 0));
  const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& t : other.triangles) mesh.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  const auto views = photo_views(mesh, corners(1.4, 0.4, 0), 90.0, 20);
  // Along north: areas 0.8 and 0.4 at heights 1 and 0.5, at -0.5 and +0.5.
  const double up = (0.8 * 1.0 + 0.4 * 0.5) / 1.2, across = (-0.4 + 0.2) / 1.2;
  EXPECT_NEAR(std::tan(views[0].alpha_left_rad), (across + 0.7) / up, kExact);
  EXPECT_NEAR(std::tan(views[0].alpha_right_rad), (0.7 - across) / up, kExact);
  // From the east one hides the other: a single rectangle 0.4 x 2.
  EXPECT_NEAR(std::tan(views[1].alpha_left_rad), 0.2 / 1.0, kExact);
}

TEST(PhotoView, NothingToSee) {
  EXPECT_TRUE(photo_views({}, corners(1, 1, 0)).empty());
  EXPECT_TRUE(photo_views(block(1, 1, 1), {}).empty());
}

}  // namespace
}  // namespace cairn::fragility
