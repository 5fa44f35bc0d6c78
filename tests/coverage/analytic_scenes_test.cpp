// Scenes whose counts and angles can be written down.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <vector>

#include "base/angle.hpp"
#include "coverage/coverage.hpp"
#include "coverage/large_facets.hpp"
#include "support/meshes.hpp"
#include "support/views.hpp"

namespace cairn::coverage {
namespace {

using geometry::TriangleMesh;
using geometry::Vec3;

constexpr double kAngle = 5.73e-3;      // deg: 1e-4 rad
constexpr double kSilhouette = 1e-3;    // |cos| below which a facet is a silhouette
constexpr double kShadowBorder = 0.02;  // m: centroids that near to a shadow's edge may fall on either side

FacetCoverage run(const TriangleMesh& mesh, const ViewSet& views) {
  base::RunContext ctx;
  return coverage(mesh, visibility::Scene(mesh), views, {}, ctx);
}

double angle_deg(const Vec3& a, const Vec3& b) {
  return base::rad_to_deg(std::atan2(a.cross(b).norm(), a.dot(b)));
}

ViewSet wide_camera() {
  ViewSet set;
  set.cameras.push_back(testing::pinhole_camera(600, 1200, 1200));  // 45 deg to each side
  return set;
}

TEST(AnalyticScenes, ABoxShowsTheFacesThatTheCamerasStandBefore) {
  const TriangleMesh mesh = cut_large_facets(testing::box(Vec3(-1, -1, 0), Vec3(1, 1, 2)), 0.3, 100000).mesh;
  ViewSet views = wide_camera();
  const std::array<Vec3, 4> places = {Vec3(5, 3, 8), Vec3(6, -0.5, 1), Vec3(-4, 7, 3), Vec3(0.4, 0.3, 9)};
  for (const Vec3& place : places) testing::add_view(views, place, Vec3(0, 0, 1));
  const FacetCoverage result = run(mesh, views);
  ASSERT_GT(mesh.triangles.size(), 800U);
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const Vec3 c = mesh.centroid(f), n = mesh.area_vector(f).normalized();
    std::uint32_t expected = 0;
    double incidence = 180.0, parallax = 0.0;
    bool silhouette = false;
    std::vector<Vec3> lines;
    for (const Vec3& place : places) {
      const Vec3 d = place - c;
      silhouette = silhouette || std::abs(n.dot(d.normalized())) < kSilhouette;
      if (!(n.dot(d) > 0.0)) continue;  // a convex body hides nothing else
      ++expected;
      incidence = std::min(incidence, angle_deg(n, d));
      for (const Vec3& line : lines) parallax = std::max(parallax, angle_deg(line, d));
      lines.push_back(d);
    }
    if (silhouette) continue;
    ASSERT_EQ(result.views[f], expected) << c.transpose();
    if (expected > 0) {
      ASSERT_NEAR(static_cast<double>(result.incidence_best_deg[f]), incidence, kAngle);
    }
    if (expected > 1) {
      ASSERT_NEAR(static_cast<double>(result.parallax_deg[f]), parallax, kAngle);
    }
  }
}

TEST(AnalyticScenes, AWallIsSeenAtTheAnglesOfItsPlane) {
  // A wall in the plane y = 0 that looks north, two cameras at 10 m from it and 6 m apart, level with z = 1.
  TriangleMesh mesh = testing::slab(-4, 0, 4, 2, 0, 16);
  for (Vec3& v : mesh.vertices) v = Vec3(-v.x(), 0.0, v.y());
  ViewSet views = wide_camera();
  testing::add_view(views, Vec3(-3, 10, 1), Vec3(-3, 0, 1));
  testing::add_view(views, Vec3(3, 10, 1), Vec3(3, 0, 1));
  const FacetCoverage result = run(mesh, views);
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const Vec3 c = mesh.centroid(f);
    ASSERT_GT(mesh.area_vector(f).y(), 0.0);
    ASSERT_EQ(result.views[f], 2U);
    const double left = std::hypot(c.x() + 3.0, c.z() - 1.0), right = std::hypot(c.x() - 3.0, c.z() - 1.0);
    ASSERT_NEAR(static_cast<double>(result.incidence_best_deg[f]),
                base::rad_to_deg(std::atan2(std::min(left, right), 10.0)), kAngle);
    ASSERT_NEAR(static_cast<double>(result.incidence_second_deg[f]),
                base::rad_to_deg(std::atan2(std::max(left, right), 10.0)), kAngle);
    ASSERT_NEAR(static_cast<double>(result.parallax_deg[f]), angle_deg(Vec3(-3, 10, 1) - c, Vec3(3, 10, 1) - c),
                kAngle);
    // Cameras square to the wall: a pixel covers distance over focal length everywhere.
    ASSERT_NEAR(static_cast<double>(result.gsd_best_mm[f]), 10000.0 / 600.0, 1e-3);
    // Both stand north of the wall within 30 deg of it in the middle third: bins 330 to 360 and 0 to 30.
    if (std::abs(c.x()) < 2.0) {
      ASSERT_EQ(result.azimuths[f], (1U << 11U) | 1U);
    }
  }
}

TEST(AnalyticScenes, TwoSlabsHideTheUnionOfTheirShadows) {
  // One camera 20 m up. A slab at height h from a to b hides the ground from a 20 / (20 - h) to b 20 / (20 - h).
  const TriangleMesh ground = testing::slab(-15, -15, 15, 15, 0, 60);
  const TriangleMesh mesh =
      testing::joined(testing::joined(ground, testing::slab(-2, -2, 2, 2, 4, 1)), testing::slab(1, -1, 6, 3, 8, 1));
  ViewSet views = wide_camera();
  testing::add_view(views, Vec3(0, 0, 20), Vec3(0, 0, 0));
  const FacetCoverage result = run(mesh, views);
  const auto in_shadow = [](const Vec3& c, double x0, double y0, double x1, double y1, double h, double grow) {
    const double s = 20.0 / (20.0 - h);
    return c.x() > s * x0 - grow && c.x() < s * x1 + grow && c.y() > s * y0 - grow && c.y() < s * y1 + grow;
  };
  std::size_t hidden = 0;
  for (std::size_t f = 0; f < ground.triangles.size(); ++f) {
    const Vec3 c = ground.centroid(f);
    const auto hides = [&](double grow) {
      return in_shadow(c, -2, -2, 2, 2, 4, grow) || in_shadow(c, 1, -1, 6, 3, 8, grow);
    };
    if (hides(kShadowBorder) != hides(-kShadowBorder)) continue;
    ASSERT_EQ(result.views[f], hides(0.0) ? 0U : 1U) << c.transpose();
    ASSERT_EQ(result.in_frame[f], 1U);  // the 2.5-D overlap knows no shadows
    hidden += hides(0.0) ? 1U : 0U;
  }
  EXPECT_GT(hidden, 500U);
  // The lower slab's own facets lie partly under the upper one; both of its facets face the camera.
  EXPECT_EQ(result.facing[ground.triangles.size()], 1U);
}

TEST(AnalyticScenes, DuplicateFacetsDoNotHideOneAnother) {
  const TriangleMesh one = testing::slab(-5, -5, 5, 5, 0, 10);
  const TriangleMesh two = testing::joined(one, one);
  ViewSet views = wide_camera();
  for (const double x : {-3.0, 0.0, 3.0}) testing::add_view(views, Vec3(x, 1, 12), Vec3(0, 0, 0));
  const FacetCoverage single = run(one, views), twice = run(two, views);
  const std::size_t n = one.triangles.size();
  for (std::size_t f = 0; f < n; ++f) {
    ASSERT_EQ(twice.views[f], single.views[f]);
    ASSERT_EQ(twice.views[f + n], single.views[f]);
    ASSERT_EQ(twice.sigma_max_mm[f + n], single.sigma_max_mm[f]);
  }
}

}  // namespace
}  // namespace cairn::coverage
