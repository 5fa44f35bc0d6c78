#include "coverage/coverage.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/parallel.hpp"
#include "camera/projection.hpp"
#include "support/brute_force_caster.hpp"
#include "support/meshes.hpp"
#include "support/views.hpp"

namespace cairn::coverage {
namespace {

using geometry::TriangleMesh;
using geometry::Vec3;
using visibility::Scene;

constexpr double kSilhouette = 1e-3;         // |cos| below which a facet is a silhouette
constexpr double kAngleTolerance = 5.73e-3;  // deg: 1e-4 rad
constexpr double kEdgeClearance = 1e-4;      // barycentric: single precision may take either side of an edge

FacetCoverage run(const TriangleMesh& mesh, const ViewSet& views, const CoverageOptions& options = {}) {
  base::RunContext ctx;
  return coverage(mesh, Scene(mesh), views, options, ctx);
}

// Rough ground with a roof of loose triangles above a part of it.
TriangleMesh rough_scene() {
  TriangleMesh mesh = testing::slab(-10, -10, 10, 10, 0, 20);
  base::Random random(11, "rough", 0);
  for (Vec3& v : mesh.vertices) v.z() = 0.8 * random.normal();
  TriangleMesh loose = testing::triangle_soup(60, 8.0, 1.5, Vec3(2, 3, 5), 12);
  return testing::joined(std::move(mesh), loose);
}

ViewSet ring_of_views(std::size_t count, const survey::Camera& camera) {
  ViewSet set;
  set.cameras.push_back(camera);
  base::Random random(13, "views", 0);
  for (std::size_t i = 0; i < count; ++i) {
    const double azimuth = random.uniform(0.0, 2.0 * std::numbers::pi), radius = random.uniform(0.0, 25.0);
    testing::add_view(set, Vec3(radius * std::cos(azimuth), radius * std::sin(azimuth), random.uniform(6, 25)),
                      Vec3(random.uniform(-4, 4), random.uniform(-4, 4), 0));
  }
  return set;
}

struct Expected {
  std::uint32_t in_frame = 0, facing = 0, views = 0;
  double gsd_mm = 1e300, incidence_deg = 1e300, second_deg = 1e300, parallax_deg = 0.0;
  double median_deg = 0.0, parallax_second_deg = 0.0;
  std::uint16_t azimuths = 0;
  bool silhouette = false;  // a view so near an edge that precision decides
};

// The definition, facet by facet and view by view, in double precision.
Expected by_definition(const TriangleMesh& mesh, std::size_t facet, const ViewSet& set, double margin) {
  Expected e;
  const Vec3 c = mesh.centroid(facet), n = mesh.area_vector(facet).normalized();
  std::vector<Vec3> lines;
  std::vector<double> incidences, angles;
  for (const View& view : set.views) {
    const survey::Camera& camera = set.cameras[view.camera];
    const Vec3 d = c - view.T_world_camera.translation;
    const double cosine = -n.dot(d.normalized());
    const auto pixel = camera::project_world(camera, view.T_world_camera, c);
    if (!pixel || !camera::inside_image(camera, *pixel, margin)) continue;
    ++e.in_frame;
    if (std::abs(cosine) < kSilhouette) e.silhouette = true;
    if (!(cosine > 0.0)) continue;
    ++e.facing;
    bool blocked = false;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      TriangleMesh grown;
      const Vec3 m = mesh.centroid(t);
      for (const auto v : mesh.triangles[t])
        grown.vertices.push_back(m + (mesh.vertices[v] - m) * (1 + kEdgeClearance));
      grown.triangles.push_back({0, 1, 2});
      const auto near = testing::intersect(grown, 0, view.T_world_camera.translation, d);
      if (!near || near->distance >= 1.0) continue;
      if (near->distance > 1.0 - 2e-4 && t != facet) e.silhouette = true;
      if (near->edge_clearance < 2 * kEdgeClearance) e.silhouette = true;
      const auto hit = testing::intersect(mesh, t, view.T_world_camera.translation, d);
      if (hit && hit->distance < 1.0 - 1e-4) blocked = true;
    }
    if (blocked) continue;
    ++e.views;
    // Pixel density by finite differences on the facet's own plane.
    const Vec3 u = n.unitOrthogonal(), w = n.cross(u);
    constexpr double kStep = 1e-4;
    const auto at = [&](const Vec3& p) { return *camera::project_world(camera, view.T_world_camera, p); };
    const geometry::Vec2 du = (at(c + kStep * u) - at(c - kStep * u)) / (2 * kStep);
    const geometry::Vec2 dw = (at(c + kStep * w) - at(c - kStep * w)) / (2 * kStep);
    e.gsd_mm = std::min(e.gsd_mm, 1000.0 / std::sqrt(std::abs(du.x() * dw.y() - du.y() * dw.x())));
    const double incidence = base::rad_to_deg(std::atan2(n.cross(d).norm(), -n.dot(d)));
    e.second_deg = std::min(e.second_deg, std::max(incidence, e.incidence_deg));
    e.incidence_deg = std::min(e.incidence_deg, incidence);
    for (const Vec3& line : lines) angles.push_back(base::rad_to_deg(std::atan2(line.cross(d).norm(), line.dot(d))));
    lines.push_back(d);
    incidences.push_back(incidence);
    const double azimuth = base::rad_to_deg(std::atan2(-d.x(), -d.y()));
    e.azimuths = static_cast<std::uint16_t>(e.azimuths |
                                            1U << static_cast<unsigned>((azimuth < 0 ? azimuth + 360 : azimuth) / 30));
  }
  std::sort(incidences.begin(), incidences.end());
  std::sort(angles.begin(), angles.end(), std::greater<>());
  if (!incidences.empty()) e.median_deg = incidences[(incidences.size() - 1) / 2];
  if (!angles.empty()) e.parallax_deg = angles[0];
  if (angles.size() > 1) e.parallax_second_deg = angles[1];
  return e;
}

void compare_with_definition(const survey::Camera& camera, double margin) {
  const TriangleMesh mesh = rough_scene();
  const ViewSet set = ring_of_views(25, camera);
  CoverageOptions options;
  options.frame_margin = margin;
  for (const auto tracing : {visibility::Tracing::watertight, visibility::Tracing::fast}) {
    base::RunContext ctx;
    const FacetCoverage result = coverage(mesh, Scene(mesh, tracing), set, options, ctx);
    std::size_t compared = 0, seen = 0, hidden = 0;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      const Expected e = by_definition(mesh, i, set, margin);
      EXPECT_EQ(result.in_frame[i], e.in_frame) << i;
      if (e.silhouette) continue;
      ++compared;
      ASSERT_EQ(result.facing[i], e.facing) << i;
      ASSERT_EQ(result.views[i], e.views) << i;
      hidden += e.facing - e.views;
      if (e.views == 0) {
        EXPECT_TRUE(std::isnan(result.gsd_best_mm[i]));
        continue;
      }
      ++seen;
      constexpr double kRelative = 1e-3;  // the distortion's table
      EXPECT_NEAR(static_cast<double>(result.gsd_best_mm[i]), e.gsd_mm, kRelative * e.gsd_mm) << i;
      EXPECT_GE(result.gsd_median_mm[i], result.gsd_best_mm[i]);
      EXPECT_NEAR(static_cast<double>(result.incidence_best_deg[i]), e.incidence_deg, kAngleTolerance) << i;
      EXPECT_NEAR(static_cast<double>(result.incidence_median_deg[i]), e.median_deg, kAngleTolerance) << i;
      EXPECT_EQ(result.azimuths[i], e.azimuths) << i;
      EXPECT_EQ(azimuth_bins(result.azimuths[i]), std::popcount(e.azimuths));
      if (e.views < 2) {
        EXPECT_TRUE(std::isnan(result.parallax_deg[i]));
        EXPECT_TRUE(std::isnan(result.sigma_max_mm[i]));
        continue;
      }
      EXPECT_GE(result.sigma_max_mm[i], result.sigma_z_mm[i]);
      EXPECT_GT(result.sigma_z_mm[i], 0.0F);
      if (e.views > 2) {
        EXPECT_NEAR(static_cast<double>(result.parallax_second_deg[i]), e.parallax_second_deg, kAngleTolerance) << i;
      }
      EXPECT_NEAR(static_cast<double>(result.incidence_second_deg[i]), e.second_deg, kAngleTolerance) << i;
      EXPECT_NEAR(static_cast<double>(result.parallax_deg[i]), e.parallax_deg, kAngleTolerance) << i;
    }
    EXPECT_GT(compared, mesh.triangles.size() * 8 / 10);
    EXPECT_GT(seen, 500U);
    EXPECT_GT(hidden, 200U);
  }
}

TEST(Coverage, EqualsTheDefinitionWithoutDistortion) {
  compare_with_definition(testing::pinhole_camera(800, 1000, 750), 0.0);
}

TEST(Coverage, EqualsTheDefinitionWithDistortionAndMargin) {
  survey::Camera camera = testing::pinhole_camera(800, 1000, 750);
  camera.model = survey::CameraModel::brown;
  camera.k1 = -0.12;
  camera.k2 = 0.03;
  camera.p1 = 0.002;
  camera.p2 = -0.001;
  camera.cx_px += 13.0;
  compare_with_definition(camera, 0.02);
}

TEST(Coverage, EqualsTheDefinitionForAFisheye) {
  survey::Camera camera = testing::pinhole_camera(300, 1000, 750);
  camera.model = survey::CameraModel::fisheye;
  camera.k1 = 0.02;
  compare_with_definition(camera, 0.0);
}

TEST(Coverage, NadirGridOverFlatGroundIsClosedForm) {
  // Cameras at height h over a plane see |x - x_c| <= h W / (2 f).
  const TriangleMesh mesh = testing::slab(0, 0, 40, 40, 0, 80);
  ViewSet set;
  set.cameras.push_back(testing::pinhole_camera(1000, 1000, 800));
  for (int i = 0; i <= 4; ++i)
    for (int j = 0; j <= 4; ++j) testing::add_view(set, Vec3(10.0 * i, 10.0 * j, 20), Vec3(10.0 * i, 10.0 * j, 0));
  const FacetCoverage result = run(mesh, set);
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const Vec3 c = mesh.centroid(f);
    std::uint32_t expected = 0;
    double nearest = 1e300, widest = 0.0;
    std::vector<Vec3> lines;
    for (const View& view : set.views) {
      const Vec3 d = view.T_world_camera.translation - c;
      if (std::abs(d.x()) > 10.0 || std::abs(d.y()) > 8.0) continue;
      ++expected;
      nearest = std::min(nearest, std::hypot(d.x(), d.y()));
      for (const Vec3& l : lines) widest = std::max(widest, std::atan2(l.cross(d).norm(), l.dot(d)));
      lines.push_back(d);
    }
    ASSERT_EQ(result.views[f], expected) << c.transpose();
    if (expected == 0) continue;
    // On a plane square to the axis a pixel covers h / f everywhere: z^3 / (r cos i) = h^2.
    ASSERT_NEAR(static_cast<double>(result.gsd_best_mm[f]), 20.0, 1e-4);
    ASSERT_NEAR(static_cast<double>(result.gsd_median_mm[f]), 20.0, 1e-4);
    ASSERT_NEAR(static_cast<double>(result.incidence_best_deg[f]), base::rad_to_deg(std::atan2(nearest, 20.0)),
                kAngleTolerance);
    if (expected > 1) {
      ASSERT_NEAR(static_cast<double>(result.parallax_deg[f]), base::rad_to_deg(widest), kAngleTolerance);
    }
  }
}

TEST(Coverage, SphereShowsTheCapThatFacesTheCamera) {
  const TriangleMesh mesh = testing::sphere(Vec3(0, 0, 0), 1.0, 30);
  ViewSet set;
  set.cameras.push_back(testing::pinhole_camera(1000, 1000, 1000));
  testing::add_view(set, Vec3(0, 0, 5), Vec3::Zero());
  testing::add_view(set, Vec3(5, 0, 0), Vec3::Zero());
  const FacetCoverage result = run(mesh, set);
  std::size_t silhouettes = 0;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    std::uint32_t expected = 0;
    bool near = false;
    for (const View& view : set.views) {
      const Vec3 d = view.T_world_camera.translation - mesh.centroid(f);
      const double cosine = mesh.area_vector(f).normalized().dot(d.normalized());
      near = near || std::abs(cosine) < kSilhouette;
      expected += cosine > 0.0 ? 1 : 0;  // a convex body hides nothing else
    }
    silhouettes += near ? 1 : 0;
    if (!near) {
      EXPECT_EQ(result.views[f], expected) << f;
    }
  }
  EXPECT_LT(silhouettes, mesh.triangles.size() / 50);
}

TEST(Coverage, WallAndOverhangAreSeenFromTheirOwnSideOnly) {
  // A table top of 4 x 4 m at 2 m height over ground of 20 x 20 m; one camera straight above, one level with the gap.
  const TriangleMesh ground = testing::slab(-10, -10, 10, 10, 0, 40);
  const TriangleMesh mesh = testing::joined(ground, testing::box(Vec3(-2, -2, 2), Vec3(2, 2, 2.5)));
  ViewSet set;
  set.cameras.push_back(testing::pinhole_camera(500, 1000, 1000));
  testing::add_view(set, Vec3(0, 0, 12.5), Vec3(0, 0, 0));
  testing::add_view(set, Vec3(-9, 0, 1), Vec3(0, 0, 1));
  const FacetCoverage result = run(mesh, set);
  for (std::size_t f = 0; f < ground.triangles.size(); ++f) {
    const Vec3 c = mesh.centroid(f);
    // The lower edge of the box's top at 2.5 m hides |x| <= 2 * 12.5 / 10 from above.
    const bool above = std::abs(c.x()) > 2.5 || std::abs(c.y()) > 2.5;
    const Vec3 in_second = c - Vec3(-9, 0, 1);
    const bool second = in_second.x() > 0 && std::abs(in_second.y()) <= in_second.x() && 1.0 <= in_second.x();
    const bool border = std::abs(std::max(std::abs(c.x()), std::abs(c.y())) - 2.5) < 1e-6;
    if (!border) {
      ASSERT_EQ(result.views[f], (above ? 1U : 0U) + (second ? 1U : 0U)) << c.transpose();
    }
  }
}

TEST(Coverage, ThreadsChangeNothing) {
  const TriangleMesh mesh = testing::joined(testing::slab(-20, -20, 20, 20, 0, 150), rough_scene());
  const ViewSet set = ring_of_views(40, testing::pinhole_camera(800, 1000, 750));
  FacetCoverage one, four;
  {
    const base::ThreadLimit limit(1);
    one = run(mesh, set);
  }
  {
    const base::ThreadLimit limit(4);
    four = run(mesh, set);
  }
  EXPECT_EQ(one.views, four.views);
  EXPECT_EQ(one.rays, four.rays);
  const auto same = [](const std::vector<float>& a, const std::vector<float>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](float x, float y) { return x == y || (std::isnan(x) && std::isnan(y)); });
  };
  EXPECT_TRUE(same(one.gsd_best_mm, four.gsd_best_mm));
  EXPECT_TRUE(same(one.gsd_median_mm, four.gsd_median_mm));
  EXPECT_TRUE(same(one.incidence_best_deg, four.incidence_best_deg));
  EXPECT_TRUE(same(one.incidence_second_deg, four.incidence_second_deg));
  EXPECT_TRUE(same(one.parallax_deg, four.parallax_deg));
}

TEST(Coverage, TriangleOrderChangesNothing) {
  TriangleMesh mesh = rough_scene();
  const ViewSet set = ring_of_views(40, testing::pinhole_camera(800, 1000, 750));
  const FacetCoverage straight = run(mesh, set);
  // Facet i moves to place 7 i mod n, which is a permutation.
  const std::size_t n = mesh.triangles.size();
  ASSERT_EQ(std::gcd<std::size_t>(7, n), 1U);
  TriangleMesh shuffled = mesh;
  for (std::size_t i = 0; i < n; ++i) shuffled.triangles[7 * i % n] = mesh.triangles[i];
  const FacetCoverage turned = run(shuffled, set);
  for (std::size_t i = 0; i < n; ++i) {
    EXPECT_EQ(turned.views[7 * i % n], straight.views[i]);
    EXPECT_EQ(turned.facing[7 * i % n], straight.facing[i]);
    if (straight.views[i] > 0) {
      EXPECT_EQ(turned.gsd_best_mm[7 * i % n], straight.gsd_best_mm[i]);
    }
  }
}

TEST(Coverage, DegenerateFacetsAreSkippedAndCounted) {
  TriangleMesh mesh = testing::slab(-1, -1, 1, 1, 0, 2);
  const std::size_t good = mesh.triangles.size();
  const auto nan = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.emplace_back(std::nan(""), 0, 0);
  mesh.vertices.emplace_back(0, 1e300, 0);
  mesh.triangles.push_back({0, 0, 1});
  mesh.triangles.push_back({0, 1, nan});
  mesh.triangles.push_back({0, 1, nan + 1});
  mesh.triangles.push_back({0, 1, 1000});
  mesh.triangles.push_back(mesh.triangles[0]);  // a duplicate is a facet like any other
  ViewSet set;
  set.cameras.push_back(testing::pinhole_camera(1000, 1000, 1000));
  testing::add_view(set, Vec3(0, 0, 5), Vec3::Zero());
  const FacetCoverage result = run(mesh, set);
  EXPECT_EQ(result.skipped, 4U);
  for (std::size_t f = 0; f < good; ++f) EXPECT_EQ(result.views[f], 1U);
  for (std::size_t f = good; f < good + 4; ++f) EXPECT_EQ(result.views[f], 0U);
  EXPECT_EQ(result.views[good + 4], 1U);
}

TEST(Coverage, CameraBelowOrInsideSeesNothingFromOutside) {
  const TriangleMesh ground = testing::slab(-5, -5, 5, 5, 0, 10);
  ViewSet set;
  set.cameras.push_back(testing::pinhole_camera(500, 1000, 1000));
  testing::add_view(set, Vec3(0, 0, -5), Vec3(0, 0, 0));
  const FacetCoverage below = run(ground, set);
  EXPECT_EQ(*std::max_element(below.views.begin(), below.views.end()), 0U);
  EXPECT_GT(*std::max_element(below.in_frame.begin(), below.in_frame.end()), 0U);
  ViewSet inside;
  inside.cameras = set.cameras;
  testing::add_view(inside, Vec3(0, 0, 0), Vec3(1, 0, 0));
  const FacetCoverage in_sphere = run(testing::sphere(Vec3::Zero(), 2.0, 12), inside);
  EXPECT_EQ(*std::max_element(in_sphere.views.begin(), in_sphere.views.end()), 0U);
}

TEST(Coverage, NoViewsAndNoFacetsAreFine) {
  const TriangleMesh mesh = testing::slab(-1, -1, 1, 1, 0, 2);
  const FacetCoverage none = run(mesh, {});
  EXPECT_EQ(none.views, std::vector<std::uint32_t>(mesh.triangles.size(), 0));
  EXPECT_TRUE(std::isnan(none.parallax_deg[0]));
  ViewSet set;
  set.cameras.push_back(testing::pinhole_camera(1000, 1000, 1000));
  testing::add_view(set, Vec3(0, 0, 5), Vec3::Zero());
  EXPECT_TRUE(run({}, set).views.empty());
}

TEST(Coverage, RefusesViewsThatMakeNoSense) {
  const TriangleMesh mesh = testing::slab(-1, -1, 1, 1, 0, 2);
  ViewSet set;
  set.cameras.push_back(testing::pinhole_camera(1000, 1000, 1000));
  testing::add_view(set, Vec3(0, 0, 5), Vec3::Zero());
  set.views[0].T_world_camera.translation.x() = std::nan("");
  EXPECT_THROW(run(mesh, set), base::Error);
  set.views[0].T_world_camera.translation.x() = 0;
  set.views[0].camera = 1;
  EXPECT_THROW(run(mesh, set), base::Error);
  set.views[0].camera = 0;
  set.cameras[0].fx_px = 0;
  EXPECT_THROW(run(mesh, set), base::Error);
  set.cameras[0].fx_px = 1000;
  CoverageOptions options;
  options.frame_margin = 0.7;
  EXPECT_THROW(run(mesh, set, options), base::Error);
}

TEST(Coverage, StopsWhenAsked) {
  base::StopFlag stop;
  stop.request();
  base::RunContext ctx(nullptr, &stop);
  const TriangleMesh mesh = testing::slab(-1, -1, 1, 1, 0, 2);
  EXPECT_THROW(coverage(mesh, Scene(mesh), {}, {}, ctx), base::Error);
}

}  // namespace
}  // namespace cairn::coverage
