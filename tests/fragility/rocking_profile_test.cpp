#include "fragility/rocking_profile.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/random.hpp"

namespace cairn::fragility {
namespace {

using geometry::Vec3;

geometry::MassProperties block_mass(double w, double d, double h) {
  geometry::MassProperties m;
  m.volume = w * d * h;
  m.centre_of_mass = Vec3(0, 0, 0.5 * h);
  m.inertia_per_density = (m.volume / 12.0 * Vec3(d * d + h * h, w * w + h * h, w * w + d * d)).asDiagonal();
  return m;
}

const std::vector<Vec3> kBase = {{-0.5, -1, 0}, {0.5, -1, 0}, {0.5, 1, 0}, {-0.5, 1, 0}};

// fragility.md 2.2: eta = 1 - 2 (m R^2 / I_O) sin^2(alpha) for a symmetric body, with toes at +b1, -b2 the general
// form.
TEST(RockingProfile, RestitutionFromGeometry) {
  const double b = 0.4, h = 1.1, i = 0.37;
  const auto even = two_toe_profile(b, h, b, h, i);
  const double r2 = b * b + h * h;
  EXPECT_NEAR(even.toes[0].eta_from_up, 1.0 - 2.0 * b * b / (i + r2), 1e-14);
  const double b1 = 0.3, b2 = 0.5;
  const auto odd = two_toe_profile(b1, h, b2, h, i);
  EXPECT_NEAR(odd.toes[0].eta_from_up, (i + h * h - b1 * b2) / (i + h * h + b2 * b2), 1e-14);
  EXPECT_NEAR(odd.toes[1].eta_from_down, (i + h * h - b1 * b2) / (i + h * h + b1 * b1), 1e-14);
  EXPECT_NEAR(odd.toes[1].alpha, std::atan2(b1, h), 1e-15);
  EXPECT_NEAR(odd.toes[0].alpha, -std::atan2(b2, h), 1e-15);
}

TEST(RockingProfile, EdgesOfABlockAreTheRectangle) {
  const auto mass = block_mass(1, 2, 3);
  const auto result = tipping(mass, kBase);
  const auto across = edge_profile(result, mass, 90.0);
  ASSERT_TRUE(across);
  const auto expected = rectangle_profile(0.5, 1.5);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(across->toes[i].alpha, expected.toes[i].alpha, 1e-12);
    EXPECT_NEAR(across->toes[i].p_squared, expected.toes[i].p_squared, 1e-12);
    EXPECT_NEAR(across->toes[i].gain, 1.0, 1e-12);
  }
  EXPECT_NEAR(across->toes[0].eta_from_up, 0.85, 1e-12);
  const auto along = edge_profile(result, mass, 0.0);
  ASSERT_TRUE(along);
  EXPECT_NEAR(base::rad_to_deg(along->toes[1].alpha), 33.690068, 5.1e-7);
  // 30 degrees beside the normal: the same edges, and cos 30 of the motion.
  const auto oblique = edge_profile(result, mass, 60.0);
  ASSERT_TRUE(oblique);
  EXPECT_NEAR(oblique->toes[1].gain, std::cos(base::deg_to_rad(30.0)), 1e-12);
  EXPECT_NEAR(oblique->toes[1].alpha, expected.toes[1].alpha, 1e-12);
}

// The profile's tipping acceleration, tan(alpha) / gain, is that of the 3-D table at every azimuth.
TEST(RockingProfile, StartsToRockAtTheTippingAcceleration) {
  base::Random random(4, "edges", 0);
  auto mass = block_mass(1, 2, 3);
  std::vector<Vec3> contacts;
  for (int i = 0; i < 12; ++i) {
    const double a = random.uniform(0.0, 6.283);
    contacts.emplace_back(0.5 * std::cos(a), 0.7 * std::sin(a), random.uniform(-0.2, 0.2));
  }
  const auto result = tipping(mass, contacts);
  ASSERT_EQ(result.equilibrium, Equilibrium::stable);
  for (int azimuth = 0; azimuth < 360; azimuth += 10) {
    const auto profile = edge_profile(result, mass, azimuth);
    if (!profile) continue;
    const auto& toe = profile->toes[1];
    const auto& edge_count = result.edges;
    ASSERT_FALSE(edge_count.empty());
    EXPECT_LE(profile->toes[0].eta_from_up * toe.eta_from_down, 1.0);
    // Level edges only meet this exactly; inclined ones leave out the motion along the edge.
    const double a = std::tan(toe.alpha) / toe.gain;
    EXPECT_NEAR(a, result.a_qs_g_by_azimuth[static_cast<std::size_t>(azimuth)],
                0.15 * result.a_qs_g_by_azimuth[static_cast<std::size_t>(azimuth)]);
  }
  const auto level = tipping(mass, kBase);
  for (int azimuth = 0; azimuth < 360; azimuth += 7) {
    const auto profile = edge_profile(level, mass, azimuth);
    ASSERT_TRUE(profile);
    EXPECT_NEAR(std::tan(profile->toes[1].alpha) / profile->toes[1].gain,
                level.a_qs_g_by_azimuth[static_cast<std::size_t>(azimuth)], 1e-12);
  }
}

TEST(RockingProfile, NoProfileWithoutEquilibrium) {
  EXPECT_FALSE(edge_profile(TippingResult{}, block_mass(1, 1, 3), 0.0));
}

TEST(RockingProfile, WrongToesAreRefused) {
  EXPECT_THROW((void)two_toe_profile(0.0, 1, 1, 1, 1), base::Error);
  RockingProfile profile = rectangle_profile(0.5, 1.5);
  profile.toes[0].eta_from_up = 1.5;
  profile.toes[1].eta_from_down = 1.5;
  EXPECT_THROW(validate(profile), base::Error);
}

}  // namespace
}  // namespace cairn::fragility
