#include "simulation/shape.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "geometry/mass_properties.hpp"
#include "geometry/primitives.hpp"

namespace cairn::simulation {
namespace {

using geometry::contains;
using geometry::Ring;
using geometry::signed_area;
using geometry::TriangleMesh;
using geometry::Vec2;
using geometry::Vec3;

constexpr double kRounding = 1e-9;  // m: sums over some thousand vertices of a body of metres
constexpr double kPi = std::numbers::pi;

ShapeSpec rock(const std::string& family) {
  ShapeSpec spec;
  spec.size_m = Vec3(1.6, 1.3, 1.9);
  spec.family = family;
  spec.pedestal_height_m = 0.6;
  spec.contact_share = 0.5;
  return spec;
}

Shape make(const ShapeSpec& spec, std::uint64_t seed = 1) {
  base::Random random(seed, "shape_test", 0);
  return make_shape(spec, random);
}

Ring plan(const std::vector<Vec3>& ring) {
  Ring flat;
  for (const Vec3& p : ring) flat.push_back(p.head<2>());
  return flat;
}

double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto to_segment = [&p](const Vec3& s, const Vec3& e) {
    const double t = std::clamp((p - s).dot(e - s) / (e - s).squaredNorm(), 0.0, 1.0);
    return (p - s - t * (e - s)).norm();
  };
  const Vec3 n = (b - a).cross(c - a);
  const auto inside = [&](const Vec3& s, const Vec3& e) { return n.dot((e - s).cross(p - s)) >= 0.0; };
  if (n.norm() > 0.0 && inside(a, b) && inside(b, c) && inside(c, a)) return std::abs(n.dot(p - a)) / n.norm();
  return std::min({to_segment(a, b), to_segment(b, c), to_segment(c, a)});
}

double distance_to(const TriangleMesh& mesh, const Vec3& p) {
  double best = 1e300;
  for (const auto& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    if ((a - p).norm() > best + (a - b).norm() + (a - c).norm()) continue;
    best = std::min(best, distance_to_triangle(p, a, b, c));
  }
  return best;
}

TEST(Shape, EveryKindIsClosedOutwardAndOfTheSizeAskedFor) {
  for (int k = 0; k < 8; ++k) {
    const auto kind = static_cast<ShapeKind>(k);
    SCOPED_TRACE(std::string(name_of(kind)));
    ASSERT_EQ(shape_kind_from(name_of(kind)), kind);
    ShapeSpec spec;
    spec.kind = kind;
    spec.size_m = Vec3(2.0, 1.4, 1.7);
    spec.azimuth_deg = 90.0;  // the length axis is east, so that extents are seen unturned
    spec.pedestal_height_m = 0.5;
    if (kind == ShapeKind::mesh) {
      ShapeSpec given;
      given.kind = ShapeKind::box;
      spec.mesh = make(given).body;
    }
    const Shape shape = make(spec);
    const auto state = topology(shape.body);
    EXPECT_TRUE(state.closed());
    EXPECT_EQ(state.degenerate_triangles, 0U);
    EXPECT_GT(shape.volume_m3, 0.0);
    EXPECT_TRUE(topology(shape.pedestal).closed());
    EXPECT_GT(geometry::mass_properties(shape.pedestal).volume, 0.0);
    EXPECT_LT((shape.body.bounds().size() - spec.size_m).norm(), kRounding);
    if (kind != ShapeKind::tree) {
      EXPECT_EQ(state.components, 1U);
    }
    if (kind != ShapeKind::rock) {
      EXPECT_NEAR(shape.body.bounds().min.z(), 0.5, kRounding);
    }
  }
}

TEST(Shape, AnalyticVolumesConvergeWithTheSquareOfTheEdge) {
  const Vec3 size(1.2, 0.8, 1.0);
  const double ellipsoid = kPi / 6.0 * size.prod(), cylinder = kPi / 4.0 * size.prod();
  const std::vector<std::pair<ShapeKind, double>> bodies = {
      {ShapeKind::ellipsoid, ellipsoid}, {ShapeKind::cylinder, cylinder}, {ShapeKind::cone, cylinder / 3.0}};
  for (const auto& [kind, exact] : bodies) {
    SCOPED_TRACE(std::string(name_of(kind)));
    ShapeSpec spec;
    spec.kind = kind;
    spec.size_m = size;
    spec.edge_m = 0.04;
    const double coarse = exact - make(spec).volume_m3;
    spec.edge_m = 0.01;
    const double fine = exact - make(spec).volume_m3;
    EXPECT_GT(fine, 0.0);  // inscribed
    // Edges four times as short: sixteen times the accuracy; sectors are whole, hence the band.
    EXPECT_NEAR(coarse / fine, 16.0, 2.0);
  }
  ShapeSpec box;
  box.kind = ShapeKind::box;
  box.size_m = size;
  EXPECT_NEAR(make(box).volume_m3, size.prod(), kRounding);
  EXPECT_LT((make(box).centre_of_mass - Vec3(0.0, 0.0, 0.5)).norm(), kRounding);
}

TEST(Shape, RocksRestInEquilibriumOnAContactThatLiesOnThem) {
  for (const std::string& family : rock_families())
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
      SCOPED_TRACE(family + " " + std::to_string(seed));
      ShapeSpec spec = rock(family);
      spec.tilt_deg = seed % 2 == 0 ? 0.0 : 12.0;
      spec.azimuth_deg = 50.0 * static_cast<double>(seed);
      spec.irregularity = 0.2 * static_cast<double>(seed);
      const Shape shape = make(spec, seed);
      EXPECT_EQ(shape.family, family);
      ASSERT_EQ(shape.contact_rim.size(), 1U);
      ASSERT_EQ(shape.contact_bearing.size(), 1U);
      const auto rim = plan(shape.contact_rim.front()), bearing = plan(shape.contact_bearing.front());
      EXPECT_GT(signed_area(rim), 0.0);
      EXPECT_GT(signed_area(bearing), 0.0);
      EXPECT_TRUE(contains(bearing, shape.centre_of_mass.head<2>()));
      for (const auto& ring : {shape.contact_rim.front(), shape.contact_bearing.front()})
        for (std::size_t i = 0; i < ring.size(); i += 16) EXPECT_LT(distance_to(shape.body, ring[i]), kRounding);
      // The bearing ring lies on the seat, the rim a gap above it (the gap leans with the rock).
      for (std::size_t i = 0; i < rim.size(); i += 16) {
        EXPECT_LT(distance_to(shape.pedestal, shape.contact_bearing.front()[i]), 2e-3);
        EXPECT_NEAR(distance_to(shape.pedestal, shape.contact_rim.front()[i]), spec.contact_gap_m, 2e-3);
      }
    }
}

TEST(Shape, BearingShareIsTheOneAskedFor) {
  ShapeSpec spec = rock("rounded");
  for (const double share : {0.2, 0.5, 0.8, 1.0}) {
    spec.contact_share = share;
    const Shape shape = make(spec, 4);
    // A seat that undulates moves the ring by its lean.
    EXPECT_NEAR(signed_area(plan(shape.contact_bearing.front())) / signed_area(plan(shape.contact_rim.front())), share,
                0.01);
  }
  spec.contact_share = 0.12;  // more finds no room inside this rim
  spec.contact_pads = 3;
  const Shape shape = make(spec, 4);
  ASSERT_EQ(shape.contact_bearing.size(), 3U);
  double area = 0.0;
  std::vector<Vec2> all;
  for (const auto& pad : shape.contact_bearing)
    for (const Vec3& p : pad) {
      all.push_back(p.head<2>());
      EXPECT_LT(distance_to(shape.pedestal, p), 2e-3);
      EXPECT_TRUE(contains(plan(shape.contact_rim.front()), p.head<2>()));
    }
  for (const auto& pad : shape.contact_bearing) area += signed_area(plan(pad));
  EXPECT_NEAR(area / signed_area(plan(shape.contact_rim.front())), 0.12, 0.01);
  EXPECT_TRUE(contains(geometry::convex_hull(all), shape.centre_of_mass.head<2>()));
}

TEST(Shape, RocksOverhangTheirContact) {
  for (const std::string& family : rock_families()) {
    const Shape shape = make(rock(family), 2);
    Ring outline;
    for (const Vec3& v : shape.body.vertices) outline.push_back(v.head<2>());
    const double share = signed_area(plan(shape.contact_rim.front())) / signed_area(geometry::convex_hull(outline));
    EXPECT_GT(share, 0.02) << family;
    EXPECT_LT(share, 0.75) << family;
  }
}

TEST(Shape, FamiliesDiffer) {
  // Volume over that of the box around: a ball has 0.52, a joint block more, a pear less than a slab.
  std::vector<double> filled;
  for (const std::string& family : rock_families()) {
    double sum = 0.0;
    for (std::uint64_t seed = 0; seed < 8; ++seed) {
      ShapeSpec spec = rock(family);
      spec.foot_share = 0.45;
      sum += make(spec, seed).volume_m3 / spec.size_m.prod() / 8.0;
    }
    filled.push_back(sum);
  }
  const double slab = filled[2], pear = filled[3];
  EXPECT_GT(slab, pear + 0.1);
  std::sort(filled.begin(), filled.end());
  for (std::size_t i = 1; i < filled.size(); ++i) EXPECT_GT(filled[i] - filled[i - 1], 1e-3);
}

TEST(Shape, SameSeedSameBytesOtherSeedOtherRock) {
  ShapeSpec spec = rock("");
  const Shape a = make(spec, 7), b = make(spec, 7), c = make(spec, 8);
  ASSERT_EQ(a.body.vertices.size(), b.body.vertices.size());
  for (std::size_t i = 0; i < a.body.vertices.size(); ++i) ASSERT_EQ(a.body.vertices[i], b.body.vertices[i]);
  ASSERT_EQ(a.pedestal.vertices.size(), b.pedestal.vertices.size());
  EXPECT_NE(a.volume_m3, c.volume_m3);
}

TEST(Shape, TheLengthAxisPointsToTheAzimuthAndTheTopLeansThere) {
  ShapeSpec spec;
  spec.kind = ShapeKind::box;
  spec.size_m = Vec3(3.0, 1.0, 1.0);
  spec.azimuth_deg = 0.0;
  EXPECT_NEAR(make(spec).body.bounds().size().y(), 3.0, kRounding);
  spec.azimuth_deg = 90.0;
  spec.tilt_deg = 10.0;
  spec.pedestal_height_m = 0.4;
  const Shape shape = make(spec);
  EXPECT_GT(shape.centre_of_mass.x(), 0.05);
  EXPECT_NEAR(shape.centre_of_mass.x(), 0.5 * std::sin(base::deg_to_rad(10.0)), kRounding);
  EXPECT_NEAR(shape.centre_of_mass.y(), 0.0, kRounding);
  EXPECT_NEAR(shape.body.bounds().min.z(), 0.4, kRounding);
  for (const Vec3& p : shape.contact_rim.front()) EXPECT_LT(distance_to(shape.pedestal, p), kRounding);
}

TEST(Shape, RefusesWhatIsOutOfRange) {
  const auto refused = [](auto change) {
    ShapeSpec spec;
    change(spec);
    try {
      (void)make(spec);
    } catch (const base::Error& error) {
      return error.code() == base::ErrorCode::invalid_argument;
    }
    return false;
  };
  EXPECT_TRUE(refused([](ShapeSpec& s) { s.size_m.z() = 0.0; }));
  EXPECT_TRUE(refused([](ShapeSpec& s) { s.size_m.x() = std::nan(""); }));
  EXPECT_TRUE(refused([](ShapeSpec& s) { s.tilt_deg = 60.0; }));
  EXPECT_TRUE(refused([](ShapeSpec& s) { s.contact_share = 0.0; }));
  EXPECT_TRUE(refused([](ShapeSpec& s) { s.contact_pads = 0; }));
  EXPECT_TRUE(refused([](ShapeSpec& s) { s.family = "marble"; }));
  EXPECT_TRUE(refused([](ShapeSpec& s) { s.kind = ShapeKind::mesh; }));
  EXPECT_TRUE(refused([](ShapeSpec& s) {
    s.kind = ShapeKind::mesh;
    s.mesh.vertices = {Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY()};
    s.mesh.triangles = {{0, 1, 2}};
  }));
}

}  // namespace
}  // namespace cairn::simulation
