#include "surface/rock_body.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/random.hpp"
#include "support/bodies.hpp"
#include "surface/mesh_checks.hpp"

namespace cairn::surface {
namespace {

using namespace cairn::testing;

double ground_at_zero(const Vec2&) {
  return 0.0;
}

RockBody must(std::variant<RockBody, base::Reject> result) {
  if (const auto* why = std::get_if<base::Reject>(&result)) {
    ADD_FAILURE() << why->reason << ": " << why->message;
    return {};
  }
  return std::get<RockBody>(std::move(result));
}

void expect_sound(const RockBody& body) {
  EXPECT_TRUE(body.quality.watertight);
  EXPECT_TRUE(body.quality.topology.closed());
  EXPECT_EQ(body.quality.topology.components, 1U);
  EXPECT_FALSE(body.quality.self_intersecting);
  EXPECT_GT(body.mass.volume, 0.0);
  EXPECT_LE(body.mass.volume, body.hull_volume * (1 + 1e-9));
  EXPECT_EQ(body.seen.size(), body.mesh.triangles.size());
}

// Half-ellipsoid seen from above.
TEST(RockBody, SparseDomeFromAbove) {
  const double a = .6, b = .5, c = .5;
  base::Random random(21, "dome", 0);
  std::vector<Vec3> points;
  while (points.size() < 3000) {
    const double x = random.uniform(-a, a), y = random.uniform(-b, b);
    const double q = x * x / (a * a) + y * y / (b * b);
    if (q < 1) points.emplace_back(x, y, c * std::sqrt(1 - q));
  }
  const double exact = 2.0 / 3.0 * std::numbers::pi * a * b * c;
  // Chords cut the dome and its rim: the error falls with the spacing.
  double previous = 1.0;
  for (const std::size_t count : {60U, 400U, 3000U}) {
    const auto body = must(build_body({{points.data(), count}, ground_at_zero, 0.03, 0.0, {}}, {}));
    expect_sound(body);
    EXPECT_EQ(body.method, "top");
    EXPECT_EQ(body.cap, survey::CapModel::plane);
    const double error = std::abs(body.mass.volume / exact - 1);
    EXPECT_LT(error, count == 60 ? 0.15 : count == 400 ? 0.04 : 0.01) << count;
    EXPECT_LT(error, previous);
    previous = error;
    EXPECT_GT(body.quality.unseen_area_fraction, 0.25);
    EXPECT_LT(body.quality.unseen_area_fraction, 0.55);
  }
}

// Points on the whole outside of a truncated ellipsoid except its base, which stands on the ground.
std::vector<Vec3> scanned_ellipsoid(double spacing, double noise) {
  const double a = .5, b = .4, c = .6, k = .45;
  base::Random random(22, "scan", 0);
  std::vector<Vec3> points;
  const auto count = static_cast<int>(4 * std::numbers::pi * .25 / (spacing * spacing));
  while (static_cast<int>(points.size()) < count) {
    Vec3 d(random.normal(), random.normal(), random.normal());
    d.normalize();
    // Rejection to an even area density: stretch of the sphere at d.
    const double stretch = a * b * c * Vec3(d.x() / a, d.y() / b, d.z() / c).norm();
    if (random.uniform() * .3 > stretch) continue;
    const Vec3 p = Vec3(a * d.x(), b * d.y(), c * d.z()) * (1 + noise * random.normal() / .5);
    if (p.z() > -k + 0.05) points.emplace_back(p + Vec3(0, 0, k));
  }
  return points;
}

BodyOptions wrap() {
  BodyOptions options;
  options.method = "wrap";
  return options;
}

TEST(RockBody, WrapOfARockSeenAllRound) {
  const auto points = scanned_ellipsoid(0.02, 0.0);
  const auto body = must(build_body({points, ground_at_zero, 0.01, 1.0, {}}, wrap()));
  expect_sound(body);
  EXPECT_EQ(body.method, "wrap");
  EXPECT_EQ(body.cap, survey::CapModel::wrap);
  const auto exact = exact_truncated_ellipsoid(.5, .4, .6, .45);
  EXPECT_NEAR(body.mass.volume / exact.volume, 1.0, 0.03);
  EXPECT_NEAR(body.mass.centre_of_mass.z(), exact.centre_of_mass.z() + .45, 0.01);
  EXPECT_LT(body.mass.centre_of_mass.head<2>().norm(), 0.01);
  // The cap and the 5 cm above it are unseen.
  const double cap_share = std::numbers::pi * .5 * .4 * (1 - .45 * .45 / .36) / body.mass.area;
  EXPECT_GT(body.quality.unseen_area_fraction, 0.5 * cap_share);
  EXPECT_LT(body.quality.unseen_area_fraction, cap_share + 0.15);
}

// Random points leave gaps of several spacings: the wrap must not line the inside.
TEST(RockBody, WrapOfACylinderOfRandomPoints) {
  base::Random random(31, "post", 0);
  std::vector<Vec3> points;
  for (int i = 0; i < 9400 + 1960; ++i) {
    const double angle = random.uniform(0, 2 * std::numbers::pi);
    const double r = i < 9400 ? 0.5 : 0.5 * std::sqrt(random.uniform());
    points.emplace_back(r * std::cos(angle), r * std::sin(angle), i < 9400 ? random.uniform(0.05, 1.2) : 1.2);
  }
  const auto body = must(build_body({points, ground_at_zero, 0.01, 1.0, {}}, wrap()));
  expect_sound(body);
  EXPECT_EQ(body.method, "wrap");
  EXPECT_NEAR(body.mass.volume / (std::numbers::pi * .25 * 1.2), 1.0, 0.02);
  EXPECT_NEAR(body.mass.centre_of_mass.z(), 0.6, 0.01);
}

// Half the wall is missing: nothing encloses the middle, and that is said.
TEST(RockBody, WrapThatLeaksIsNotUsed) {
  std::vector<Vec3> points;
  for (int i = 0; i < 60; ++i)
    for (int k = 2; k < 60; ++k) {
      const double angle = std::numbers::pi * i / 60;
      points.emplace_back(0.5 * std::cos(angle), 0.5 * std::sin(angle), 0.02 * k);
    }
  const auto result = build_body({points, ground_at_zero, 0.02, 1.0, {}}, wrap());
  ASSERT_TRUE(std::holds_alternative<base::Reject>(result));
  EXPECT_EQ(std::get<base::Reject>(result).reason, "wrap_leaks");
}

TEST(RockBody, MethodIsChosenByWhatWasSeen) {
  const auto points = scanned_ellipsoid(0.02, 0.0);
  EXPECT_EQ(must(build_body({points, ground_at_zero, 0.01, 0.2, {}}, {})).method, "top");
  BodyOptions top;
  top.method = "top";
  EXPECT_EQ(must(build_body({points, ground_at_zero, 0.01, 1.0, {}}, top)).method, "top");
}

TEST(RockBody, RejectsWhatHasNoBody) {
  const auto reason = [](const std::vector<Vec3>& points) {
    const auto result = build_body({points, ground_at_zero, 0.1, 0.0, {}}, {});
    const auto* why = std::get_if<base::Reject>(&result);
    return why != nullptr ? why->reason : std::string("none");
  };
  EXPECT_EQ(reason({{0, 0, 1}, {1, 0, 1}}), "too_few_points");
  EXPECT_EQ(reason({{0, 0, 1}, {1, 1, 1}, {2, 2, 1}, {3, 3, 2}}), "flat_points");
  EXPECT_EQ(reason({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}), "flat_points");
}

// No contact is given: the foot is dropped to the ground and its outline told as assumed.
TEST(RockBody, ImplicitOfARockSeenAllRound) {
  const auto points = scanned_ellipsoid(0.02, 0.005);
  const auto body = must(build_body({points, ground_at_zero, 0.01, 1.0, {}}, {}));
  expect_sound(body);
  EXPECT_EQ(body.method, "implicit");
  EXPECT_EQ(body.cap, survey::CapModel::plane);
  EXPECT_TRUE(body.contact_assumed);
  EXPECT_GT(body.contact.size(), 10U);
  for (const auto& v : body.contact) {
    EXPECT_EQ(v.position.z(), 0.0);
    EXPECT_FALSE(v.observed);
  }
  const auto exact = exact_truncated_ellipsoid(.5, .4, .6, .45);
  EXPECT_NEAR(body.mass.volume / exact.volume, 1.0, 0.02);
  EXPECT_NEAR(body.mass.centre_of_mass.z(), exact.centre_of_mass.z() + .45, 0.01);
  EXPECT_GT(body.cap_height_sigma, 0.0);
}

// A rock on a pedestal, the ground far below: the base lies at the lowest band, not on the ground.
TEST(RockBody, NoVisibleBase) {
  const auto points = scanned_ellipsoid(0.02, 0.005);
  const auto deep = [](const Vec2&) { return -1.0; };
  const auto body = must(build_body({points, deep, 0.01, 1.0, {}}, {}));
  expect_sound(body);
  EXPECT_GT(body.mesh.bounds().min.z(), 0.0);
  EXPECT_TRUE(body.contact_assumed);
}

TEST(RockBody, PlanarCloudHasNoImplicitSurface) {
  std::vector<Vec3> points;
  for (int i = 0; i < 40; ++i)
    for (int k = 0; k < 40; ++k) points.emplace_back(0.02 * i, 0.02 * k, 0.5);
  BodyOptions options;
  options.method = "implicit";
  const auto result = build_body({points, ground_at_zero, 0.02, 1.0, {}}, options);
  ASSERT_TRUE(std::holds_alternative<base::Reject>(result));
  EXPECT_EQ(std::get<base::Reject>(result).reason, "implicit_unsupported");
  const auto body = must(build_body({points, ground_at_zero, 0.02, 1.0, {}}, {}));
  EXPECT_EQ(body.method, "top");
  EXPECT_THAT(body.notes, ::testing::Contains("implicit_unsupported"));
}

}  // namespace
}  // namespace cairn::surface
