#include "evaluation/cylinder_overlap.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "base/random.hpp"
#include "support/meshes.hpp"

namespace cairn::evaluation {
namespace {

using geometry::Vec2;
using geometry::Vec3;
using geometry::VerticalCylinder;
constexpr double kPi = std::numbers::pi;

TEST(CylinderOverlap, KnownValues) {
  const VerticalCylinder a{Vec2(0, 0), 0.0, 2.0, 1.0};
  EXPECT_DOUBLE_EQ(volume(a), 2.0 * kPi);
  EXPECT_DOUBLE_EQ(iou(a, a), 1.0);
  EXPECT_NEAR(iou(a, {Vec2(0, 0), 0.0, 1.0, 1.0}), 0.5, 1e-15);
  EXPECT_NEAR(iou(a, {Vec2(0, 0), 0.0, 2.0, 2.0}), 0.25, 1e-15);  // one inside the other
  EXPECT_DOUBLE_EQ(iou(a, {Vec2(2, 0), 0.0, 2.0, 1.0}), 0.0);     // touching
  EXPECT_DOUBLE_EQ(iou(a, {Vec2(0, 0), 2.0, 3.0, 1.0}), 0.0);
  EXPECT_DOUBLE_EQ(iou({Vec2(0, 0), 0, 0, 0}, {Vec2(0, 0), 0, 0, 0}), 0.0);
  // Unit circles a radius apart: 2 pi / 3 - sqrt(3) / 2.
  EXPECT_NEAR(circle_intersection(Vec2(0, 0), 1.0, Vec2(1, 0), 1.0), 2.0 * kPi / 3.0 - std::sqrt(3.0) / 2.0, 1e-14);
}

TEST(CylinderOverlap, CirclesAgainstCounting) {
  base::Random random(3, "circles", 0);
  for (int trial = 0; trial < 20; ++trial) {
    const Vec2 b(random.uniform(-2, 2), random.uniform(-2, 2));
    const double ra = random.uniform(0.2, 2), rb = random.uniform(0.2, 2);
    constexpr int kCells = 400;
    double counted = 0.0;
    for (int i = 0; i < kCells; ++i)
      for (int j = 0; j < kCells; ++j) {
        const Vec2 p(-2 + 4 * (i + 0.5) / kCells, -2 + 4 * (j + 0.5) / kCells);
        if (p.norm() <= ra && (p - b).norm() <= rb) counted += 16.0 / (kCells * kCells);
      }
    EXPECT_NEAR(circle_intersection(Vec2(0, 0), ra, b, rb), counted, 0.02) << trial;  // m^2: cells along the rim
  }
}

// A box of 2 x 2 x 1 m that stands on a contact of 1 x 1 m: exposed are the top, four sides and the overhang.
class ExposedBox : public ::testing::Test {
 protected:
  void SetUp() override {
    mesh_ = testing::box(Vec3(-1, -1, 0), Vec3(1, 1, 1));
    object_.cylinder = {Vec2(0, 0), 0.0, 1.0, std::sqrt(2.0)};
    object_.contact_rim = {{Vec3(-0.5, -0.5, 0), Vec3(0.5, -0.5, 0), Vec3(0.5, 0.5, 0), Vec3(-0.5, 0.5, 0)}};
  }
  [[nodiscard]] static double area(const std::vector<SurfacePatch>& patches) {
    double sum = 0.0;
    for (const auto& p : patches) sum += p.area_m2;
    return sum;
  }
  geometry::TriangleMesh mesh_;
  survey::TruthObject object_;
};

TEST_F(ExposedBox, LeavesOutTheContact) {
  EXPECT_NEAR(area(exposed_surface(mesh_, object_, 0.05)), 4.0 + 8.0 + 3.0, 0.05);  // m^2: patches on the rim
  object_.contact_rim.clear();
  EXPECT_NEAR(area(exposed_surface(mesh_, object_)), 16.0, 1e-9);
  object_.cylinder.bottom = 0.5;                                              // half of it is buried
  EXPECT_NEAR(area(exposed_surface(mesh_, object_, 0.05)), 4.0 + 4.0, 0.15);  // m^2: one row of patches on four sides
}

TEST_F(ExposedBox, ShareInsideACylinder) {
  const auto surface = exposed_surface(mesh_, object_, 0.02);
  EXPECT_DOUBLE_EQ(*contained_share(surface, object_.cylinder), 1.0);
  // A circle of radius 0.99 holds 0.9801 pi of the 4 m^2 of the top, 1 m^2 less of the overhang, and no side.
  EXPECT_NEAR(*contained_share(surface, {Vec2(0, 0), 0.0, 1.0, 0.99}), (1.9602 * kPi - 1.0) / 15.0, 0.005);
  EXPECT_NEAR(*contained_share(surface, {Vec2(0, 0), 0.5, 1.0, 5.0}), (4.0 + 4.0) / 15.0, 0.005);
  EXPECT_DOUBLE_EQ(*contained_share(surface, {Vec2(50, 0), 0.0, 1.0, 1.0}), 0.0);
  EXPECT_FALSE(contained_share({}, object_.cylinder).has_value());
}

}  // namespace
}  // namespace cairn::evaluation
