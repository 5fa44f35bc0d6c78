#include "surface/implicit_surface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/random.hpp"
#include "geometry/kd_tree.hpp"
#include "support/bodies.hpp"
#include "surface/mesh_checks.hpp"

namespace cairn::surface {
namespace {

using namespace cairn::testing;

constexpr double kPi = std::numbers::pi;

Vec3 direction(base::Random& random) {
  return Vec3(random.normal(), random.normal(), random.normal()).normalized();
}

std::vector<Vec3> noisy_sphere(std::size_t count, double radius, double noise, const Vec3& centre = Vec3::Zero()) {
  base::Random random(5, "noisy_sphere", 0);
  std::vector<Vec3> points;
  while (points.size() < count) points.push_back(centre + (radius + noise * random.normal()) * direction(random));
  return points;
}

ImplicitSurface surface_of(const std::vector<Vec3>& points, std::span<const CapPatch> caps = {}) {
  return implicit_surface(points, caps, surface_spacing(points), {});
}

double volume(const ImplicitSurface& s) {
  return geometry::mass_properties(s.surface.mesh).volume;
}

void expect_sound(const ImplicitSurface& s) {
  const auto topology = geometry::topology(s.surface.mesh);
  EXPECT_TRUE(topology.closed());
  EXPECT_EQ(topology.components, 1U);
  EXPECT_EQ(topology.degenerate_triangles, 0U);
  EXPECT_FALSE(self_intersects(s.surface.mesh));
  EXPECT_EQ(s.surface.seen.size(), s.surface.mesh.triangles.size());
}

double unseen_share(const ImplicitSurface& s) {
  double unseen = 0.0, whole = 0.0;
  for (std::size_t t = 0; t < s.surface.seen.size(); ++t) {
    const double area = s.surface.mesh.area_vector(t).norm();
    whole += area;
    if (s.surface.seen[t] == 0) unseen += area;
  }
  return unseen / whole;
}

TEST(ImplicitSurface, SpacingIsThatOfTheArea) {
  const auto points = noisy_sphere(20000, 0.5, 0.0);
  const double expected = std::sqrt(kPi / 20000.0);
  // The 70th percentile of random points lies a little above the mean.
  EXPECT_GT(surface_spacing(points), expected);
  EXPECT_LT(surface_spacing(points), 1.2 * expected);
  EXPECT_EQ(surface_spacing(noisy_sphere(8, 0.5, 0.0)), 0.0);
}

TEST(ImplicitSurface, NoiseDoesNotBiasTheVolume) {
  const double exact = kPi / 6.0;
  // 0.2 %: what independent errors of 5 mm leave at this size is below 0.05 %, chords cost 0.05 %.
  constexpr double kTolerance = 2e-3;
  for (const double noise : {0.0, 0.002, 0.005}) {
    const auto made = surface_of(noisy_sphere(20000, 0.5, noise));
    expect_sound(made);
    EXPECT_NEAR(volume(made) / exact, 1.0, kTolerance) << noise;
    // The fit follows the points a little: up to a fifth less.
    EXPECT_LE(made.noise, 1.05 * noise + 1e-4);
    EXPECT_GE(made.noise, 0.8 * noise);
    EXPECT_LT(unseen_share(made), 0.01);
  }
}

TEST(ImplicitSurface, TheOrderOfPointsAndTheirOriginDoNotMatter) {
  auto points = noisy_sphere(3000, 0.4, 0.003);
  const auto first = surface_of(points);
  auto other = points;
  std::reverse(other.begin(), other.end());
  other.insert(other.end(), points.begin(), points.begin() + 500);
  const auto second = implicit_surface(other, {}, first.spacing, {});
  ASSERT_EQ(first.surface.mesh.vertices.size(), second.surface.mesh.vertices.size());
  for (std::size_t i = 0; i < first.surface.mesh.vertices.size(); ++i)
    ASSERT_EQ(first.surface.mesh.vertices[i], second.surface.mesh.vertices[i]);
  const Vec3 utm(500000.0, 3.8e6, 1500.0);
  for (auto& p : points) p += utm;
  const auto far = implicit_surface(points, {}, first.spacing, {});
  expect_sound(far);
  EXPECT_NEAR(volume(far) / volume(first), 1.0, 1e-5);
}

TEST(ImplicitSurface, HoleIsBridgedAndFlagged) {
  auto points = noisy_sphere(20000, 0.5, 0.003);
  const double edge = std::cos(35.0 * kPi / 180.0);
  std::erase_if(points, [&](const Vec3& p) { return p.normalized().x() > edge; });
  const auto made = surface_of(points);
  expect_sound(made);
  // A flat bridge would lose pi h^2 (3 r - h) / 3 of the cap.
  const double h = 0.5 * (1.0 - edge), flat = kPi * h * h * (1.5 - h) / 3.0;
  EXPECT_GT(volume(made), kPi / 6.0 - 1.1 * flat);
  EXPECT_LT(volume(made), kPi / 6.0 * 1.01);
  EXPECT_NEAR(unseen_share(made), 0.5 * (1.0 - edge), 0.03);
}

TEST(ImplicitSurface, PointsApartAreLeftOut) {
  auto points = noisy_sphere(5000, 0.5, 0.002);
  const double alone = volume(surface_of(points));
  for (const auto& p : noisy_sphere(100, 0.05, 0.0, {2.0, 0.0, 0.0})) points.push_back(p);
  const auto made = surface_of(points);
  EXPECT_EQ(made.stray_points, 100U);
  EXPECT_NEAR(volume(made) / alone, 1.0, 2e-3);
}

TEST(ImplicitSurface, NothingClosedFromAPlaneOrALine) {
  base::Random random(8, "plane", 0);
  std::vector<Vec3> plane, line;
  for (int i = 0; i < 2000; ++i) {
    plane.emplace_back(random.uniform(0, 1), random.uniform(0, 1), 0.0);
    line.emplace_back(random.uniform(0, 1), 0.0, 0.0);
  }
  EXPECT_TRUE(surface_of(plane).surface.mesh.triangles.empty());
  EXPECT_TRUE(surface_of(line).surface.mesh.triangles.empty());
  EXPECT_TRUE(surface_of({{0, 0, 0}, {1, 0, 0}}).surface.mesh.triangles.empty());
}

TEST(ImplicitSurface, NoiseAloneGivesNothingOrSomethingClosed) {
  base::Random random(9, "noise", 0);
  std::vector<Vec3> points;
  for (int i = 0; i < 3000; ++i) points.push_back(Vec3(random.uniform(), random.uniform(), random.uniform()));
  const auto made = surface_of(points);
  EXPECT_TRUE(made.surface.mesh.triangles.empty() || geometry::topology(made.surface.mesh).closed());
}

std::vector<Vec3> ellipse_ring(double a, double b, double z, double wave) {
  std::vector<Vec3> ring;
  for (int i = 0; i < 180; ++i) {
    const double t = 2.0 * kPi * i / 180.0;
    ring.emplace_back(a * std::cos(t), b * std::sin(t), z + wave * std::cos(2.0 * t));
  }
  return ring;
}

TEST(CapPatch, PassesThroughItsLine) {
  constexpr double kWave = 0.03, kStep = 0.01;
  const auto ring = ellipse_ring(0.4, 0.3, 1.0, kWave);
  const CapPatch patch(ring, survey::CapModel::patch, Vec3::UnitZ(), kStep);
  const CapPatch plane(ring, survey::CapModel::plane, Vec3::UnitZ(), kStep);
  double depth = 0.0;
  for (const auto& p : ring) {
    EXPECT_NEAR(patch.below(p, depth), 0.0, 0.3 * kStep);
    EXPECT_NEAR(depth, 0.0, 0.3 * kStep);
    EXPECT_NEAR(plane.below(p, depth), -(p.z() - 1.0), 0.3 * kStep);
  }
  // A saddle over an ellipse: its middle lies close to the plane.
  EXPECT_NEAR(patch.below({0, 0, 0.9}, depth), 0.1, 0.25 * kWave);
  EXPECT_GT(depth, 0.25);
  EXPECT_NEAR(patch.roughness(), kWave / std::numbers::sqrt2, 0.003);
  EXPECT_NEAR(patch.area(), kPi * 0.12, 0.002);
  for (const auto& p : patch.samples()) EXPECT_NEAR(patch.below(p, depth), 0.0, 1e-6);
  const std::vector<CapPatch> caps{patch};
  EXPECT_NEAR(cap_height_sigma(caps, 0.01, 0.02), std::sqrt(std::pow(patch.roughness(), 2) + 0.0005), 1e-12);
}

TEST(CapPatch, OutlinesOfTheContact) {
  survey::Contact contact;
  const auto add = [&contact](std::int64_t pad, std::int64_t order, const Vec3& p) {
    survey::ContactVertex v;
    v.pad = pad;
    v.order = order;
    v.position = p;
    contact.push_back(v);
  };
  EXPECT_TRUE(pad_outlines(contact).empty());
  add(2, 1, {1, 0, 0});
  add(2, 0, {0, 0, 0});
  add(2, 2, {1, 1, 0});
  add(1, 0, {5, 5, 0});  // a single contact point has no outline
  add(3, 0, {0, 0, 0});  // nor has a line
  add(3, 1, {1, 0, 0});
  add(3, 2, {2, 0, 0});
  const auto outlines = pad_outlines(contact);
  ASSERT_EQ(outlines.size(), 1U);
  EXPECT_EQ(outlines[0][1], Vec3(1, 0, 0));
}

// Truncated ellipsoid on its contact line: the closed surface ends exactly there.
TEST(ImplicitSurface, EndsAtTheContactLine) {
  const double a = .5, b = .4, c = .6, k = .45;
  base::Random random(22, "scan", 0);
  std::vector<Vec3> points;
  while (points.size() < 15000) {
    const Vec3 d = direction(random);
    const double stretch = a * b * c * Vec3(d.x() / a, d.y() / b, d.z() / c).norm();
    if (random.uniform() * .3 > stretch) continue;
    const Vec3 p(a * d.x(), b * d.y(), c * d.z());
    if (p.z() > -k + 0.005) points.push_back(p + 0.002 * Vec3(random.normal(), random.normal(), random.normal()));
  }
  const double share = std::sqrt(1.0 - k * k / (c * c));
  const auto ring = ellipse_ring(share * a, share * b, -k, 0.0);
  const double spacing = surface_spacing(points);
  const std::vector<CapPatch> caps{CapPatch(ring, survey::CapModel::patch, Vec3::UnitZ(), spacing)};
  const auto made = surface_of(points, caps);
  expect_sound(made);
  const auto exact = exact_truncated_ellipsoid(a, b, c, k);
  EXPECT_NEAR(volume(made) / exact.volume, 1.0, 3e-3);
  const auto mass = geometry::mass_properties(made.surface.mesh);
  EXPECT_NEAR(mass.centre_of_mass.z(), exact.centre_of_mass.z(), 0.002);
  const auto& mesh = made.surface.mesh;
  // Errors of the points let the flank end a little outside the line, where the cap droops.
  EXPECT_NEAR(mesh.bounds().min.z(), -k, 0.3 * made.step);
  const geometry::KdTree tree(mesh.vertices);
  for (const auto& p : ring)
    EXPECT_LT(std::sqrt(tree.nearest(p, 1).front().squared_distance), 0.75 * made.step);  // vertices are a step apart
  EXPECT_NEAR(unseen_share(made), kPi * share * share * a * b / mass.area, 0.03);
}

}  // namespace
}  // namespace cairn::surface
