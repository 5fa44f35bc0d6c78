#include "fragility/rolling.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fragility/subjects.hpp"
#include "support/bodies.hpp"

namespace cairn::fragility {
namespace {

using namespace cairn::testing;
using ::testing::Contains;

// Whole ellipsoid with its pole at -c, pole ring fine enough for a curvature.
TriangleMesh ellipsoid(double a, double b, double c) {
  std::vector<Vec2> profile{{0.0, -c}};
  constexpr int kSteps = 120;
  for (int i = 1; i < kSteps; ++i) {
    const double latitude = std::numbers::pi * (static_cast<double>(i) / kSteps - 0.5);
    profile.emplace_back(std::cos(latitude), c * std::sin(latitude));
  }
  profile.emplace_back(0.0, c);
  return revolve(profile, 96, a, b);
}

// Curvatures at the pole: c/a^2 and c/b^2; on a flat seat stable iff H = c is below the lesser radius.
TEST(RollingRule, EllipsoidOnAFlatSeat) {
  constexpr double kQuadric = 0.03;  // relative: the quadric spans a tenth of the height
  const auto flat = ellipsoid(1.5, 1.2, 1.0);
  const auto lying = rolling_rule(flat, geometry::mass_properties(flat), {0, 0, -1});
  ASSERT_TRUE(lying);
  EXPECT_NEAR(lying->rock_curvature_1_m, 1.0 / (1.2 * 1.2), kQuadric / (1.2 * 1.2));
  EXPECT_NEAR(lying->height_m, 1.0, 1e-9);
  EXPECT_TRUE(lying->stable);
  const auto tall = ellipsoid(0.9, 1.4, 1.0);
  const auto upright = rolling_rule(tall, geometry::mass_properties(tall), {0, 0, -1});
  ASSERT_TRUE(upright);
  EXPECT_FALSE(upright->stable);
  // A hollow seat of radius 3 m holds it: 1/1 > 1/0.81 - 1/3.
  EXPECT_TRUE(rolling_rule(tall, geometry::mass_properties(tall), {0, 0, -1}, -1.0 / 3.0)->stable);
  // A convex one of radius 0.5 m does not even hold the flat one.
  EXPECT_FALSE(rolling_rule(flat, geometry::mass_properties(flat), {0, 0, -1}, 2.0)->stable);
}

TEST(RollingRule, CannotTell) {
  const auto coarse = block(1, 1, 3);
  EXPECT_FALSE(rolling_rule(coarse, geometry::mass_properties(coarse), {0, 0, 0}));
  EXPECT_FALSE(rolling_rule(coarse, geometry::mass_properties(coarse), {0, 0, 3.5}));  // above the centre of mass
}

TEST(RollingRule, APointContactIsNamedAndHasNoAngle) {
  const auto mesh = ellipsoid(1.5, 1.2, 1.0);
  Subject subject;
  subject.mesh = &mesh;
  subject.mass = geometry::mass_properties(mesh);
  subject.contact = closed_pad({{0, 0, -1}});
  subject.evidence.contact_assumed = false;
  const auto result = assess(subject, {}, draw_random);
  EXPECT_EQ(result.tipping.grade, survey::Grade::not_measurable);
  EXPECT_THAT(result.tipping.reasons, Contains("point_contact"));
  EXPECT_THAT(result.tipping.reasons, Contains("rolls_back"));
  ASSERT_TRUE(result.tipping.rolling);
  EXPECT_FALSE(result.tipping.critical);
  EXPECT_TRUE(result.draws.empty());
}

}  // namespace
}  // namespace cairn::fragility
