#include "coverage/target_audit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "support/meshes.hpp"
#include "support/views.hpp"

namespace cairn::coverage {
namespace {

using geometry::TriangleMesh;
using geometry::Vec2;
using geometry::Vec3;
using ::testing::Contains;
using ::testing::Not;

constexpr std::size_t kPassed = static_cast<std::size_t>(Verdict::passed);

ViewSet nadir_flight(double height, double spacing, double half) {
  ViewSet set;
  set.cameras.push_back(testing::pinhole_camera(2285.7, 4000, 2250));
  for (double e = -half; e <= half; e += spacing)
    for (double n = -half; n <= half; n += spacing) testing::add_view(set, Vec3(e, n, height), Vec3(e, n, 0));
  return set;
}

// Rings of cameras about the origin that look at height `up`.
void add_orbit(ViewSet& set, double radius, double height, double up, int count) {
  for (int i = 0; i < count; ++i) {
    const double a = 2.0 * std::numbers::pi * i / count;
    testing::add_view(set, Vec3(radius * std::sin(a), radius * std::cos(a), height), Vec3(0, 0, up));
  }
}

TargetBody body(double radius, double height, const Vec2& axis = Vec2::Zero(), double bottom = 0.0) {
  return {survey::TargetId(1), {axis, bottom, bottom + height, radius}, {}};
}

TargetsAudit run(const TriangleMesh& surface, const std::vector<TargetBody>& bodies, const ViewSet& views,
                 const TargetOptions& options = {}) {
  base::RunContext ctx;
  return audit_targets(surface, {}, visibility::Scene(surface), bodies, views, {}, {}, options, ctx);
}

// Squares of half an edge and height, one above the other, joined by walls; closed at the top.
TriangleMesh squares(const std::vector<std::pair<double, double>>& rings) {
  TriangleMesh mesh;
  for (const auto& [half, up] : rings)
    for (const auto& [e, n] : {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)})
      mesh.vertices.emplace_back(half * e, half * n, up);
  for (std::uint32_t r = 0; r + 1 < rings.size(); ++r)
    for (std::uint32_t k = 0; k < 4; ++k) {
      const std::uint32_t a = 4 * r + k, b = 4 * r + (k + 1) % 4;
      mesh.triangles.push_back({a, b, b + 4});
      mesh.triangles.push_back({a, b + 4, a + 4});
    }
  const auto top = static_cast<std::uint32_t>(4 * (rings.size() - 1));
  mesh.triangles.push_back({top, top + 1, top + 2});
  mesh.triangles.push_back({top, top + 2, top + 3});
  return mesh;
}

TEST(TargetAudit, NadirFlightsFailOnWallsAndBasalBand) {
  const TriangleMesh ground = testing::slab(-20, -20, 20, 20, 0, 40);
  const TargetsAudit result = run(ground, {body(0.8, 1.5)}, nadir_flight(15, 3, 9));
  ASSERT_EQ(result.targets.size(), 1U);
  const TargetAudit& t = result.targets[0];
  EXPECT_GT(t.top.completeness(), 0.99);
  EXPECT_LT(t.wall.completeness(), 0.5);
  EXPECT_LT(t.basal.seen_share, 0.5);
  EXPECT_FALSE(t.passed);
  EXPECT_THAT(t.reasons, Contains("wall"));
  EXPECT_THAT(t.reasons, Contains("basal_band"));
  EXPECT_THAT(t.reasons, Not(Contains("top")));
}

TEST(TargetAudit, RoundsOfTheTargetPass) {
  const TriangleMesh ground = testing::slab(-20, -20, 20, 20, 0, 40);
  ViewSet views = nadir_flight(15, 3, 9);
  add_orbit(views, 8.0, 2.0, 0.6, 24);
  add_orbit(views, 8.0, 5.0, 0.6, 24);
  const TargetsAudit result = run(ground, {body(0.8, 1.5)}, views);
  const TargetAudit& t = result.targets[0];
  EXPECT_GT(t.wall.completeness(), 0.99);
  EXPECT_EQ(t.basal.seen_share, 1.0);
  EXPECT_FALSE(t.basal.contact_known);
  EXPECT_NEAR(t.basal.perimeter_m, 2 * std::numbers::pi * 0.8, 1e-9);
  EXPECT_EQ(t.azimuth_bins, 12);
  EXPECT_TRUE(t.passed) << t.reasons.size();
  EXPECT_LT(t.basal.gsd_best_mm, 5.0);
  EXPECT_NEAR(t.wall.area_m2, 2 * std::numbers::pi * 0.8 * 1.5, 0.01);
  EXPECT_NEAR(t.top.area_m2, std::numbers::pi * 0.64, 0.01);
}

TEST(TargetAudit, OneSideIsSeenFromOneSide) {
  // Cameras to the east only, level with the middle: the incidence on the wall is the difference of the azimuths.
  ViewSet views;
  views.cameras.push_back(testing::pinhole_camera(2285.7, 4000, 2250));
  for (const double n : {-4.0, -2.0, 0.0, 2.0, 4.0}) testing::add_view(views, Vec3(50, n, 0.75), Vec3(0, 0, 0.75));
  TargetOptions options;
  options.max_gsd_of_height = 0.0;
  options.basal.max_gsd_mm = 0.0;
  const TargetsAudit result = run({}, {body(1.0, 1.5)}, views, options);
  const TargetAudit& t = result.targets[0];
  for (std::size_t s = 0; s < kSectors; ++s) {
    const double from_east = std::abs(90.0 - 5.0 * (static_cast<double>(s) + 0.5));
    const double turned = std::min(from_east, 360.0 - from_east);
    // The views stand within 4.6 deg of east; at 60 deg of incidence a facet is too oblique.
    if (turned < 50.0 || turned > 70.0) {
      EXPECT_EQ(t.wall_by_azimuth[s], turned < 50.0 ? 1.0 : 0.0) << s;
    }
    EXPECT_EQ(t.basal.seen_by_azimuth[s], t.wall_by_azimuth[s]) << s;
  }
  EXPECT_NEAR(t.wall.completeness(), 1.0 / 3.0, 0.06);
  EXPECT_EQ(t.azimuth_bins, 2);  // 60-90 and 90-120 deg
  EXPECT_THAT(t.reasons, Contains("azimuths"));
}

TEST(TargetAudit, WhatStandsInTheWayHidesTheWall) {
  // A wall of the surface east of the target, higher than the cameras' sight lines.
  const TriangleMesh wall = testing::box(Vec3(3, -10, 0), Vec3(3.2, 10, 5));
  ViewSet views;
  views.cameras.push_back(testing::pinhole_camera(2285.7, 4000, 2250));
  for (const double n : {-4.0, 0.0, 4.0}) testing::add_view(views, Vec3(20, n, 1.0), Vec3(0, 0, 0.75));
  const TargetsAudit result = run(wall, {body(1.0, 1.5)}, views);
  EXPECT_GT(result.targets[0].wall.area_by_verdict[static_cast<std::size_t>(Verdict::occluded)], 3.0);
  EXPECT_EQ(result.targets[0].wall.area_by_verdict[kPassed], 0.0);
  EXPECT_EQ(result.targets[0].azimuth_bins, 0);
}

TEST(TargetAudit, TheSurfacesOwnPictureOfTheTargetDoesNotHideIt) {
  // A terrain model shows the boulder as a cone that is wider than the boulder at its foot.
  TriangleMesh ground = testing::slab(-10, -10, 10, 10, 0, 80);
  for (Vec3& v : ground.vertices) v.z() = std::max(0.0, 1.5 * (1.0 - (v.head<2>().norm() - 0.7) / 0.4));
  for (Vec3& v : ground.vertices) v.z() = std::min(v.z(), 1.5);
  ViewSet views = nadir_flight(15, 3, 9);
  add_orbit(views, 8.0, 2.0, 0.6, 24);
  TargetOptions options;
  options.clearance_m = 0.4;
  EXPECT_GT(run(ground, {body(0.8, 1.5)}, views, options).targets[0].wall.completeness(), 0.99);
  options.clearance_m = 0.0;
  EXPECT_LT(run(ground, {body(0.8, 1.5)}, views, options).targets[0].wall.completeness(), 0.7);
}

TEST(TargetAudit, WhatLiesInTheGroundIsLeftOut) {
  // A slope rising to the east: the ground beside the wall is at 0.5 x.
  TriangleMesh slope = testing::slab(-10, -10, 10, 10, 0, 80);
  for (Vec3& v : slope.vertices) v.z() = 0.5 * v.x();
  const TargetsAudit result = run(slope, {body(1.0, 2.0)}, nadir_flight(15, 3, 9));
  const PartAudit& wall = result.targets[0].wall;
  // Mean of max(0, sin a) / 2 over the circle = 1 / (2 pi) of a metre of 2 m.
  const double circumference = 2 * std::numbers::pi;
  EXPECT_NEAR(wall.buried_m2, circumference / (2 * std::numbers::pi), 0.15);
  EXPECT_NEAR(wall.area_m2 + wall.buried_m2, 2.0 * circumference, 0.02);
}

TEST(TargetAudit, NeighboursHideOneAnother) {
  ViewSet views;
  views.cameras.push_back(testing::pinhole_camera(2285.7, 4000, 2250));
  for (const double n : {-3.0, 0.0, 3.0}) testing::add_view(views, Vec3(30, n, 0.5), Vec3(0, 0, 0.5));
  const TargetsAudit alone = run({}, {body(1.0, 1.0)}, views);
  const TargetsAudit two = run({}, {body(1.0, 1.0), body(1.5, 2.0, Vec2(3.0, 0.0))}, views);
  EXPECT_EQ(alone.targets[0].wall.area_by_verdict[static_cast<std::size_t>(Verdict::occluded)], 0.0);
  EXPECT_GT(two.targets[0].wall.area_by_verdict[static_cast<std::size_t>(Verdict::occluded)], 2.0);
}

TEST(TargetAudit, AKnownContactIsLookedAtOnTheSurface) {
  // A rock of 2 x 2 x 1 m whose underside rises by 45 deg from a pedestal of 0.8 x 0.8 x 0.6 m.
  const double inner = 0.4;
  const TriangleMesh surface = testing::joined(testing::slab(-10, -10, 10, 10, 0, 20),
                                               squares({{inner, 0.0}, {inner, 0.6}, {1.0, 1.2}, {1.0, 1.6}}));
  TargetBody rock = body(std::sqrt(2.0), 1.0, Vec2::Zero(), 0.6);
  const auto vertex = [](double e, double n, std::int64_t order) {
    return survey::ContactVertex{0, order, Vec3(e, n, 0.6), true, true, 0.01};
  };
  rock.contact = {vertex(-inner, -inner, 0), vertex(inner, -inner, 1), vertex(inner, inner, 2),
                  vertex(-inner, inner, 3)};
  TargetOptions options;
  options.basal.max_gsd_mm = 10.0;
  ViewSet high = nadir_flight(15, 3, 9);
  const TargetsAudit from_above = run(surface, {rock}, high, options);
  EXPECT_TRUE(from_above.targets[0].basal.contact_known);
  EXPECT_NEAR(from_above.targets[0].basal.perimeter_m, 8 * inner, 1e-9);
  EXPECT_EQ(from_above.targets[0].basal.seen_share, 0.0);  // the overhang hides all of it
  ViewSet low;
  low.cameras = high.cameras;
  add_orbit(low, 6.0, 0.35, 0.55, 36);
  add_orbit(low, 6.0, 0.15, 0.55, 36);
  const TargetsAudit from_below = run(surface, {rock}, low, options);
  EXPECT_GT(from_below.targets[0].basal.seen_share, 0.9);
  // Cameras to the south alone see the southern quarter.
  ViewSet south = low;
  std::erase_if(south.views, [](const View& v) { return v.T_world_camera.translation.y() > -5.5; });
  const BasalAudit basal = run(surface, {rock}, south, options).targets[0].basal;
  EXPECT_NEAR(basal.seen_share, 0.25, 0.03);
  EXPECT_GT(basal.seen_by_azimuth[kSectors / 2], 0.9);  // due south
  EXPECT_EQ(basal.seen_by_azimuth[0], 0.0);
}

TEST(TargetAudit, ClosedFacetsAtTheContactAreNoData) {
  const TriangleMesh surface =
      testing::joined(testing::slab(-5, -5, 5, 5, 0, 50), testing::box(Vec3(-1, -1, 0), Vec3(1, 1, 1)));
  TargetBody rock = body(1.5, 1.0);
  for (int i = 0; i < 4; ++i)
    rock.contact.push_back({0, i, Vec3(i == 1 || i == 2 ? 1 : -1, i > 1 ? 1 : -1, 0), true, true, 0.01});
  std::vector<std::uint8_t> observed(surface.triangles.size(), 0);
  base::RunContext ctx;
  ViewSet views = nadir_flight(15, 3, 9);
  add_orbit(views, 8, 3, 0, 36);
  const auto result =
      audit_targets(surface, observed, visibility::Scene(surface), {rock}, views, {}, {}, {}, ctx).targets[0].basal;
  EXPECT_EQ(result.no_data_share, 1.0);
  EXPECT_EQ(result.seen_share, 0.0);
  rock.contact.clear();
  rock.contact.push_back({0, 0, Vec3(100, 100, 0), true, false, 0.01});
  rock.contact.push_back({0, 1, Vec3(101, 100, 0), true, false, 0.01});
  const auto off = audit_targets(surface, observed, visibility::Scene(surface), {rock}, views, {}, {}, {}, ctx);
  EXPECT_FALSE(off.targets[0].basal.contact_known);
  ASSERT_EQ(off.rejects.size(), 1U);
  EXPECT_EQ(off.rejects[0].reason, "contact_off_surface");
}

TEST(TargetAudit, RefusesWhatIsNoCylinder) {
  const double nan = std::nan("");
  std::vector<TargetBody> bodies = {body(1.0, 0.0), body(0.0, 1.0), body(nan, 1.0), body(1.0, -1.0), body(1.0, 1.0)};
  for (std::size_t i = 0; i < bodies.size(); ++i) bodies[i].id = survey::TargetId(static_cast<std::int64_t>(i));
  const TargetsAudit result = run({}, bodies, nadir_flight(15, 5, 5));
  ASSERT_EQ(result.targets.size(), 1U);
  EXPECT_EQ(result.targets[0].id.value, 4);
  ASSERT_EQ(result.rejects.size(), 4U);
  EXPECT_EQ(result.rejects[0].reason, "cylinder_without_height");
  EXPECT_EQ(result.rejects[1].reason, "cylinder_without_radius");
  EXPECT_EQ(result.rejects[2].reason, "cylinder_not_finite");
  EXPECT_EQ(result.rejects[3].record, "target 3");
  // Without views nothing is seen, and all is said.
  ViewSet none;
  const TargetsAudit unseen = run({}, {body(1.0, 1.0)}, none);
  EXPECT_FALSE(unseen.targets[0].passed);
  EXPECT_TRUE(std::isnan(unseen.targets[0].sigma_95_mm));
  EXPECT_EQ(unseen.targets[0].basal.seen_share, 0.0);
}

TEST(CylinderMesh, IsClosedButForItsBottomAndTurnedOutward) {
  const geometry::VerticalCylinder c{Vec2(3, -2), 1.0, 4.0, 2.0};
  const TriangleMesh mesh = cylinder_mesh(c);
  ASSERT_EQ(mesh.triangles.size(), kCylinderFacets);
  EXPECT_EQ(geometry::topology(mesh).boundary_edges, kSectors);
  EXPECT_EQ(geometry::topology(mesh).inconsistent_edges, 0U);
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const Vec3 n = mesh.area_vector(f).normalized(), centre = mesh.centroid(f);
    if (f >= kWallFacets) {
      EXPECT_GT(n.z(), 0.999);
      continue;
    }
    const Vec2 out = (centre.head<2>() - c.axis).normalized();
    EXPECT_GT(n.head<2>().dot(out), 0.999);
    const WallPlace place = wall_place(f);
    const Vec2 middle = (sector_point(c.axis, c.radius, place.sector) - c.axis).normalized();
    EXPECT_GT(out.dot(middle), std::cos(2.5 * std::numbers::pi / 180.0));
    EXPECT_NEAR(centre.z(), c.bottom + 3.0 * (static_cast<double>(place.row) + 0.5) / kWallRows, 3.0 / kWallRows / 2);
  }
}

}  // namespace
}  // namespace cairn::coverage
