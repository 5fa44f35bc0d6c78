#include "fragility/contact_bounds.hpp"

#include <gtest/gtest.h>

#include <array>

#include "base/angle.hpp"
#include "fragility/subjects.hpp"
#include "support/bodies.hpp"

namespace cairn::fragility {
namespace {

using namespace cairn::testing;

constexpr double kTolerance = 1e-6;  // m, of equilibrium
constexpr double kExact = 1e-9;
constexpr std::array<double, 3> kGaps{0.01, 0.02, 0.05};

survey::Contact square(double half) {
  return closed_pad({{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}});
}

TEST(ContactBounds, SeenAllRoundOnlyTheInsetIsOpen) {
  const auto bounds = contact_bounds(exact_block(1, 1, 3), square(0.5), 0.3, kTolerance);
  ASSERT_TRUE(bounds.inner.critical && bounds.outer.critical);
  EXPECT_NEAR(std::tan(bounds.outer.critical->alpha_rad), 0.5 / 1.5, kExact);
  EXPECT_NEAR(std::tan(bounds.inner.critical->alpha_rad), 0.7 * 0.5 / 1.5, kExact);
  EXPECT_EQ(bounds.inner.a_qs_g_by_azimuth.size(), 360U);
  const auto none = contact_bounds(exact_block(1, 1, 3), square(0.5), 0.0, kTolerance);
  EXPECT_NEAR(none.inner.critical->alpha_rad, none.outer.critical->alpha_rad, kExact);
}

// The east side was not seen: the lower bound stands on what was, the upper bound on the closed crease.
TEST(ContactBounds, MissingSector) {
  auto contact = densified(square(0.5), 0.1, 1000);
  for (auto& v : contact) v.observed = v.position.x() < 0.25;
  const auto bounds = contact_bounds(exact_block(1, 1, 3), contact, 0.0, kTolerance);
  ASSERT_TRUE(bounds.inner.critical && bounds.outer.critical);
  EXPECT_NEAR(std::tan(bounds.outer.critical->alpha_rad), 0.5 / 1.5, kExact);
  EXPECT_NEAR(std::tan(bounds.inner.critical->alpha_rad), 0.2 / 1.5, kExact);
  EXPECT_NEAR(bounds.inner.critical->azimuth_deg, 90.0, 1e-6);
  // Less than half seen: the seen part cannot hold the rock, and that is said.
  for (auto& v : contact) v.observed = v.position.x() < -0.25;
  const auto half = contact_bounds(exact_block(1, 1, 3), contact, 0.0, kTolerance);
  EXPECT_FALSE(half.inner.critical);
  EXPECT_EQ(half.inner.reason, "not_in_equilibrium");
  EXPECT_TRUE(half.inner.a_qs_g_by_azimuth.empty());
  for (auto& v : contact) v.observed = false;
  EXPECT_EQ(contact_bounds(exact_block(1, 1, 3), contact, 0.0, kTolerance).inner.reason, "no_contact_seen");
}

TEST(ContactBounds, PadsTakenAway) {
  // Four feet of a 2 x 2 table; without one the plumb point lies on the diagonal of the other three.
  survey::Contact contact;
  int pad = 0;
  for (const auto& [x, y] : {std::pair{-1., -1.}, {1., -1.}, {1., 1.}, {-1., 1.}}) {
    for (auto v : square(0.1)) {
      v.position += Vec3(x, y, 0);
      v.pad = pad;
      contact.push_back(v);
    }
    ++pad;
  }
  const auto variants = without_each_pad(exact_block(3, 3, 3), contact, kTolerance);
  ASSERT_EQ(variants.size(), 4U);
  for (const auto& v : variants) {
    ASSERT_TRUE(v.alpha_rad) << v.name;
    // The diagonal between the outer corners of the two neighbours' pads passes 0.1 sqrt(2) beyond the middle.
    EXPECT_NEAR(std::tan(*v.alpha_rad), 0.1 * std::sqrt(2.0) / 1.5, kExact);
  }
  EXPECT_NEAR(*variants[2].azimuth_deg, 45.0, 1e-6);
  EXPECT_TRUE(without_each_pad(exact_block(1, 1, 3), square(0.5), kTolerance).empty());
  // Two feet: without one there is no equilibrium, not an alpha of zero.
  survey::Contact two(contact.begin(), contact.begin() + 8);
  for (std::size_t i = 4; i < 8; ++i) two[i].position.y() += 2.0;
  for (const auto& v : without_each_pad(exact_block(3, 3, 3), two, kTolerance)) {
    EXPECT_FALSE(v.alpha_rad);
    EXPECT_EQ(v.reason, "not_in_equilibrium");
  }
}

TEST(ContactBounds, GapsOnABlockChangeNothing) {
  const auto mesh = block(1, 1, 3);
  for (const auto& v : by_gap(geometry::mass_properties(mesh), mesh, square(0.5), kGaps, kTolerance)) {
    ASSERT_TRUE(v.alpha_rad);
    EXPECT_NEAR(std::tan(*v.alpha_rad), 1.0 / 3.0, kExact) << v.name;
  }
}

// A ball with a small flat foot bears on a circle of radius sqrt(2 r (k + g)): the foot's zero-gap line is too narrow.
TEST(ContactBounds, GapsWidenTheFootOfABall) {
  const double r = 1.0, k = 0.98;
  const auto mesh = truncated_ellipsoid(r, r, r, k, 256);
  const double foot = std::sqrt(r * r - k * k);
  std::vector<Vec3> ring;
  for (const auto& p : regular_polygon(256, foot)) ring.emplace_back(p.x(), p.y(), -k);
  const auto mass = geometry::mass_properties(mesh);
  const auto variants = by_gap(mass, mesh, closed_pad(ring), kGaps, kTolerance);
  constexpr double kFacets = 4e-3;  // relative: chords of 1.3 deg, seen at a slant
  for (const auto& v : variants) {
    const double reach = std::sqrt(r * r - (k - v.value) * (k - v.value));
    const double height = mass.centre_of_mass.z() + k;
    ASSERT_TRUE(v.alpha_rad);
    EXPECT_NEAR(std::tan(*v.alpha_rad), reach / height, kFacets * reach / height) << v.name;
  }
  EXPECT_LT(*variants[0].alpha_rad, *variants[2].alpha_rad);
}

TEST(ContactBounds, DensifiedLine) {
  auto contact = square(0.5);
  contact[1].observed = false;
  contact[1].sigma_m = 0.1;
  const auto dense = densified(contact, 0.1, 1000);
  EXPECT_EQ(dense.size(), 40U);
  EXPECT_NEAR(observed_share(dense), 0.5, 1e-12);
  EXPECT_NEAR(dense[5].sigma_m, 0.05, 1e-12);
  EXPECT_LE(densified(contact, 0.001, 60).size(), 64U);
  const auto thin = densified(dense, 0.1, 20);
  EXPECT_LE(thin.size(), 24U);
  EXPECT_GE(thin.size(), 12U);
}

TEST(ContactBounds, PlaneOfTheContact) {
  auto contact = square(0.5);
  for (auto& v : contact) v.position.z() = 10.0 - 0.1 * v.position.x();
  const auto plane = contact_plane(contact);
  EXPECT_NEAR(plane.slope, std::atan(0.1), kExact);
  EXPECT_NEAR(plane.aspect_deg, 90.0, 1e-9);  // falls eastwards
  EXPECT_EQ(contact_plane(square(0.5)).slope, 0.0);
  EXPECT_EQ(contact_plane(closed_pad({{0, 0, 0}, {1, 0, 1}, {2, 0, 2}})).slope, 0.0);  // a line fixes no plane
}

}  // namespace
}  // namespace cairn::fragility
