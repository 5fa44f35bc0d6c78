#include "fragility/tipping.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/random.hpp"
#include "geometry/rigid_transform.hpp"
#include "support/bodies.hpp"

namespace cairn::fragility {
namespace {

using namespace cairn::testing;
using geometry::mass_properties;
using Points = std::vector<Vec3>;

constexpr double kEightDigits = 5.1e-9;  // half a unit of the last printed digit
constexpr double kSixDigits = 5.1e-7;
constexpr double kFiveDigits = 5.1e-6;
constexpr double kExact = 1e-10;  // relative: closed forms in double
const Vec3 kUtm(500000.0, 3.8e6, 1500.0);

Points rectangle(double w, double d, double z) {
  return {{-w / 2, -d / 2, z}, {w / 2, -d / 2, z}, {w / 2, d / 2, z}, {-w / 2, d / 2, z}};
}

// The edge whose outward normal points to the azimuth.
const Edge& edge_towards(const TippingResult& result, double azimuth_deg) {
  const Edge* best = nullptr;
  double least = 1e9;
  for (const auto& e : result.edges) {
    const double off = std::abs(std::remainder(e.azimuth_deg - azimuth_deg, 360.0));
    if (off < least) least = off, best = &e;
  }
  EXPECT_LT(least, 1e-6);
  return *best;
}

struct Row {
  const char* name;
  MassProperties mass;
  Points contact;
  double towards_deg;
  double alpha_deg, r, inertia, p, a_qs, v_min;
};

class ReferenceTable : public ::testing::TestWithParam<Row> {};

TEST_P(ReferenceTable, EveryValue) {
  const auto& row = GetParam();
  const auto result = tipping(row.mass, row.contact);
  ASSERT_EQ(result.equilibrium, Equilibrium::stable);
  const Edge& e = edge_towards(result, row.towards_deg);
  EXPECT_NEAR(base::rad_to_deg(e.alpha), row.alpha_deg, kSixDigits);
  EXPECT_NEAR(e.r, row.r, kEightDigits);
  EXPECT_NEAR(e.inertia_per_mass, row.inertia, kEightDigits);
  EXPECT_NEAR(e.p, row.p, kEightDigits);
  EXPECT_NEAR(e.a_qs_g, row.a_qs, kEightDigits);
  EXPECT_NEAR(e.v_min, row.v_min, kSixDigits);
  EXPECT_NEAR(e.barrier_per_mass, kGravity * row.r * (1 - std::cos(base::deg_to_rad(row.alpha_deg))), 1e-6);
  EXPECT_NEAR(result.a_qs_g_by_azimuth.at(static_cast<std::size_t>(row.towards_deg)), row.a_qs, kEightDigits);
}

// A circle of contact stands as a square around it: tangent edges have the circle's own distance.
INSTANTIATE_TEST_SUITE_P(
    Section62, ReferenceTable,
    ::testing::Values(Row{"block_1x1x3", exact_block(1, 1, 3), rectangle(1, 1, 0), 90, 18.434949, 1.58113883,
                          3.33333333, 2.15678059, .33333333, 1.535458},
                      Row{"block_1x2x3_long_way", exact_block(1, 2, 3), rectangle(1, 2, 0), 0, 33.690068, 1.80277564,
                          4.33333333, 2.01985470, .66666667, 3.381860},
                      Row{"block_half", exact_block(.5, .5, 1.5), rectangle(.5, .5, 0), 270, 18.434949, .79056942,
                          .83333333, 3.05014837, .33333333, 1.085732},
                      Row{"cylinder", exact_frustum(.5, .5, 3), rectangle(1, 1, 0), 180, 18.434949, 1.58113883, 3.3125,
                          2.16355229, .33333333, 1.530652},
                      Row{"frustum", exact_frustum(.3, .8, 2), rectangle(.6, .6, 0), 90, 13.155843, 1.31809919,
                          2.10811856, 2.47620656, .23373494, .931807},
                      Row{"ellipsoid_to_y", exact_truncated_ellipsoid(1, .8, 1.2, .9),
                          rectangle(2 * std::sqrt(1 - .81 / 1.44), 1.6 * std::sqrt(1 - .81 / 1.44), -.9), 0, 29.246531,
                          1.08306279, 1.5582, 2.61081173, .55994737, 2.173669},
                      Row{"ellipsoid_to_x", exact_truncated_ellipsoid(1, .8, 1.2, .9),
                          rectangle(2 * std::sqrt(1 - .81 / 1.44), 1.6 * std::sqrt(1 - .81 / 1.44), -.9), 90, 34.989490,
                          1.15348385, 1.789725, 2.51404441, .69993421, 2.862681},
                      Row{"sphere", exact_truncated_ellipsoid(1, 1, 1, .8), rectangle(1.2, 1.2, -.8), 90, 36.027373,
                          1.02011029, 1.428, 2.64679191, .72727273, 2.833515},
                      Row{"hemisphere", exact_truncated_ellipsoid(1, 1, 1, 0), rectangle(2, 2, 0), 0, 69.443955,
                          1.06800047, 1.4, 2.73515562, 2.66666667, 11.632548},
                      Row{"cone", exact_frustum(.5, 0, 2), rectangle(1, 1, 0), 90, 45, .70710678, .6875, 3.17589757, 1,
                          3.342249}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(Tipping, BlockHeadlineAndBarrier) {
  const auto mass = exact_block(1, 2, 3);
  const auto result = tipping(mass, rectangle(1, 2, 0));
  ASSERT_TRUE(result.critical);
  const Edge& e = result.edges[*result.critical];
  EXPECT_NEAR(e.alpha, std::atan(0.5 / 1.5), kExact);
  EXPECT_THAT(e.azimuth_deg, ::testing::AnyOf(::testing::DoubleNear(90, 1e-9), ::testing::DoubleNear(270, 1e-9)));
  EXPECT_NEAR(result.a_qs_min_g, 1.0 / 3.0, kExact);
  EXPECT_NEAR(result.plumb_margin, 0.5, kExact);
  // Definition (a) sees corners only: too large by the corner's distance.
  EXPECT_NEAR(std::tan(result.alpha_point), std::hypot(.5, 1.) / 1.5, kExact);
  EXPECT_EQ(result.support.size(), 4U);
}

TEST(Tipping, RegularPrismByAzimuth) {
  const double radius = 0.7, height = 1.2;
  for (const int n : {3, 5, 6, 12}) {
    const auto ring = regular_polygon(n, radius, 0.4);
    const auto mass = mass_properties(prism(ring, height));
    Points contact;
    for (const auto& p : ring) contact.emplace_back(p.x(), p.y(), 0.0);
    const auto result = tipping(mass, contact);
    ASSERT_EQ(result.edges.size(), static_cast<std::size_t>(n));
    const double apothem = radius * std::cos(std::numbers::pi / n);
    double largest = 0.0, least = 1e9;
    for (std::size_t k = 0; k < 360; ++k) {
      double nearest = 1e9;
      for (const auto& e : result.edges)
        nearest = std::min(nearest, std::abs(std::remainder(e.azimuth_deg - static_cast<double>(k), 360.0)));
      const double expected = apothem / (height / 2) / std::cos(base::deg_to_rad(nearest));
      EXPECT_NEAR(result.a_qs_g_by_azimuth[k], expected, kExact);
      largest = std::max(largest, result.a_qs_g_by_azimuth[k]);
      least = std::min(least, result.a_qs_g_by_azimuth[k]);
    }
    EXPECT_LE(largest / least, 1.0 / std::cos(std::numbers::pi / n) + kExact);
    EXPECT_NEAR(result.a_qs_min_g, apothem / (height / 2), kExact);
  }
}

TEST(Tipping, OffsetPrismHasTwoAngles) {
  auto mass = exact_block(1, 1, 3);
  mass.centre_of_mass.x() += 0.2;
  const auto result = tipping(mass, rectangle(1, 1, 0));
  EXPECT_NEAR(edge_towards(result, 90).alpha, std::atan(0.3 / 1.5), kExact);
  EXPECT_NEAR(edge_towards(result, 270).alpha, std::atan(0.7 / 1.5), kExact);
  EXPECT_NEAR(result.edges[*result.critical].azimuth_deg, 90, 1e-9);
}

TEST(Tipping, BlockOnASlope) {
  // Section 6.4. Turned about +y by 10 deg, so that +x (azimuth 90) is downslope.
  const Mat3 tilt = geometry::axis_rotation(Vec3::UnitY(), base::deg_to_rad(10));
  auto mass = exact_block(1, 1, 3);
  mass.centre_of_mass = tilt * mass.centre_of_mass;
  mass.inertia_per_density = tilt * mass.inertia_per_density * tilt.transpose();
  Points contact = rectangle(1, 1, 0);
  for (auto& q : contact) q = tilt * q;
  ASSERT_LT(contact[1].z(), contact[0].z());
  const auto result = tipping(mass, contact);
  const std::vector<std::pair<std::size_t, double>> expected = {{90, .14829048},  {45, .20971441},  {135, .20971441},
                                                                {0, .32826925},   {180, .32826925}, {315, .49276543},
                                                                {225, .49276543}, {270, .54148654}};
  for (const auto& [azimuth, a] : expected) EXPECT_NEAR(result.a_qs_g_by_azimuth[azimuth], a, kEightDigits) << azimuth;
  const double alpha_base = std::atan(0.5 / 1.5), beta = base::deg_to_rad(10);
  EXPECT_NEAR(edge_towards(result, 90).alpha, alpha_base - beta, kExact);
  EXPECT_NEAR(edge_towards(result, 270).alpha, alpha_base + beta, kExact);
  const Edge& cross = edge_towards(result, 0);
  EXPECT_NEAR(cross.inclination, beta, kExact);
  EXPECT_NEAR(cross.alpha, alpha_base, kExact);
  EXPECT_NEAR(cross.a_qs_g, std::cos(beta) / 3.0, kExact);
  EXPECT_NEAR(cross.p, std::sqrt(kGravity * cross.r * std::cos(beta) / cross.inertia_per_mass), kExact);
  EXPECT_NEAR(cross.inertia_per_mass, 10.0 / 3.0, kExact);
}

MassProperties point_mass(const Vec3& c) {
  auto mass = exact_block(1, 1, 1);
  mass.centre_of_mass = c;
  return mass;
}

TEST(Tipping, NonCoplanarContactsOfTheReference) {
  // Section 7.2: u = (cos, sin) of 0, 60, .. deg, so the azimuth is 90 - angle.
  const auto result = tipping(point_mass({0, 0, 2}), Points{{1, -.6, 0}, {-.5, -.8, 0}, {-.5, .9, 0}, {0, .05, .5}});
  const std::vector<double> expected = {.20000, .14641, .50000, .25000, .45870, .39313};
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_NEAR(result.a_qs_g_by_azimuth[(450 - 60 * i) % 360], expected[i], kFiveDigits) << 60 * i;
}

// Independent tilt test: project the contacts along f = (a u, -g) on the plane through the centre of mass,
// and ask whether any triangle of images holds it (Caratheodory); bisect on a.
bool stands(const Points& contacts, const Vec3& c, const Vec2& u, double a_g) {
  std::vector<Vec2> image;
  for (const auto& q : contacts) image.push_back((q - c).head<2>() + a_g * (q.z() - c.z()) * u);
  const auto side = [](const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); };
  for (std::size_t i = 0; i < image.size(); ++i)
    for (std::size_t j = 0; j < image.size(); ++j)
      for (std::size_t k = 0; k < image.size(); ++k)
        if (side(image[i], image[j]) >= 0 && side(image[j], image[k]) >= 0 && side(image[k], image[i]) >= 0 &&
            side(image[j] - image[i], image[k] - image[i]) > 0)
          return true;
  return false;
}

TEST(Tipping, AgreesWithTheTiltTestOnRandomContacts) {
  int standing = 0;
  for (std::uint64_t trial = 0; trial < 300; ++trial) {
    base::Random random(7, "tipping", trial);
    const bool coplanar = trial % 3 == 0;
    Points contacts;
    for (int i = 0; i < 4 + static_cast<int>(random.below(5)); ++i)
      contacts.emplace_back(random.uniform(-1, 1), random.uniform(-1, 1), coplanar ? 0.0 : random.uniform(-.6, .6));
    const Vec3 c(random.uniform(-.4, .4), random.uniform(-.4, .4), random.uniform(0.8, 2.5));
    const auto result = tipping(point_mass(c), contacts);
    ASSERT_EQ(result.equilibrium == Equilibrium::stable, stands(contacts, c, Vec2::UnitX(), 0.0)) << trial;
    if (result.equilibrium != Equilibrium::stable) continue;
    ++standing;
    double least_alpha = 1e9;
    for (std::size_t k = 0; k < 360; k += 15) {
      const double azimuth = base::deg_to_rad(static_cast<double>(k));
      const Vec2 u(std::sin(azimuth), std::cos(azimuth));
      double lo = 0.0, hi = 100.0;
      while (hi - lo > 1e-11 * (1 + lo)) (stands(contacts, c, u, 0.5 * (lo + hi)) ? lo : hi) = 0.5 * (lo + hi);
      EXPECT_NEAR(result.a_qs_g_by_azimuth[k], lo, 1e-8 * (1 + lo)) << trial << " azimuth " << k;
      // The torque formula of section 7.2 over the edges kept.
      double formula = 1e9;
      for (const auto& e : result.edges) {
        const Vec3 t = (e.ends[1] - e.ends[0]).normalized(), r = c - e.ends[0];
        const double a = t.dot(r.cross(Vec3::UnitZ())) / t.dot(r.cross(Vec3(u.x(), u.y(), 0)));
        if (a > 0) formula = std::min(formula, a);
      }
      EXPECT_NEAR(formula, lo, 1e-8 * (1 + lo)) << trial;
    }
    for (const auto& e : result.edges) {
      least_alpha = std::min(least_alpha, e.alpha);
      // Rotating the centre of mass by alpha about the edge brings it into the edge's vertical plane.
      const Vec3 t = (e.ends[1] - e.ends[0]).normalized();
      const Vec3 turned = Eigen::AngleAxisd(e.alpha, t) * (c - e.ends[0]);
      const double azimuth = base::deg_to_rad(e.azimuth_deg);
      EXPECT_NEAR(turned.dot(Vec3(std::sin(azimuth), std::cos(azimuth), 0)), 0.0, 1e-9) << trial;
      // p^2 I = g R cos(delta): the rate of change of potential energy's slope at the top.
      EXPECT_NEAR(e.p * e.p * e.inertia_per_mass, kGravity * e.r * std::cos(e.inclination), 1e-9);
      // The velocity step carries just the barrier: angular momentum in, energy out.
      if (std::isfinite(e.v_min)) {
        const double omega = e.v_min * e.r * std::cos(e.alpha) / e.inertia_per_mass;
        EXPECT_NEAR(0.5 * e.inertia_per_mass * omega * omega, e.barrier_per_mass, 1e-9 * (1 + e.barrier_per_mass));
      }
    }
    EXPECT_DOUBLE_EQ(result.edges[*result.critical].alpha, least_alpha);
    if (coplanar) {
      EXPECT_NEAR(std::tan(least_alpha), result.a_qs_min_g, kExact);
    }
  }
  EXPECT_GT(standing, 100);
}

TEST(Tipping, OffsetYawAndScale) {
  const auto mesh = prism({{1, 1}, {1, 2}, {0, 2}, {0, 0}, {2, 0}, {2, 1}}, 3, {0.1, -0.05});
  Points contact;
  for (const auto& v : mesh.vertices)
    if (v.z() == 0.0) contact.push_back(v + Vec3(0, 0, 0.02 * v.x() * v.y()));
  const auto plain = tipping(mass_properties(mesh), contact);
  ASSERT_EQ(plain.equilibrium, Equilibrium::stable);
  const auto redo = [&](const Vec3& offset, double yaw, double scale) {
    TriangleMesh carrier;
    carrier.vertices = contact;
    return tipping(mass_properties(moved(mesh, offset, yaw, scale)), moved(carrier, offset, yaw, scale).vertices);
  };
  const Edge& e = plain.edges[*plain.critical];

  const auto utm = redo(kUtm, 0, 1);
  const Edge& e_utm = utm.edges[*utm.critical];
  constexpr double kOffsetTolerance = 2e-9;  // coordinates at 3.8e6 m are rounded to 2.3e-10 m
  EXPECT_NEAR(e_utm.alpha, e.alpha, kOffsetTolerance);
  EXPECT_NEAR(e_utm.p, e.p, kOffsetTolerance);
  EXPECT_NEAR(e_utm.v_min, e.v_min, 10 * kOffsetTolerance);

  const auto yawed = redo(Vec3::Zero(), base::deg_to_rad(30), 1);  // counter-clockwise: azimuths fall by 30
  EXPECT_NEAR(yawed.edges[*yawed.critical].alpha, e.alpha, kExact);
  for (std::size_t k = 0; k < 360; ++k)
    EXPECT_NEAR(yawed.a_qs_g_by_azimuth[(k + 330) % 360], plain.a_qs_g_by_azimuth[k], kExact);

  const double s = 0.3048;
  const auto feet = redo(Vec3::Zero(), 0, s);
  const Edge& e_feet = feet.edges[*feet.critical];
  EXPECT_NEAR(e_feet.alpha, e.alpha, kExact);
  EXPECT_NEAR(e_feet.r, e.r * s, kExact);
  EXPECT_NEAR(e_feet.p, e.p / std::sqrt(s), kExact * 10);
  EXPECT_NEAR(e_feet.v_min, e.v_min * std::sqrt(s), kExact * 10);

  auto heavy = mass_properties(mesh);
  const auto again = tipping(heavy, contact);
  EXPECT_EQ(again.edges[*again.critical].p, e.p);
}

TEST(Tipping, ReportsWhatCannotStand) {
  const auto mass = exact_block(1, 1, 3);
  EXPECT_EQ(tipping(mass, Points{}).equilibrium, Equilibrium::no_contact);
  EXPECT_EQ(tipping(mass, Points{{0, 0, 0}, {0, 0, 0}}).equilibrium, Equilibrium::point_contact);
  EXPECT_EQ(tipping(mass, Points{{-1, 0, 0}, {0, 0, 0}, {1, 0, 0}}).equilibrium, Equilibrium::line_contact);
  EXPECT_EQ(tipping(mass, Points{{.1, 0, 0}, {1, 0, 0}, {1, 1, 0}}).equilibrium, Equilibrium::plumb_point_outside);
  // On the border alpha would be 0: not in equilibrium either.
  EXPECT_EQ(tipping(mass, Points{{0, -1, 0}, {1, 0, 0}, {0, 1, 0}}).equilibrium, Equilibrium::plumb_point_outside);
  Points socket = rectangle(1, 1, 0);
  socket.emplace_back(.5, 0, 1.6);
  EXPECT_EQ(tipping(mass, socket).equilibrium, Equilibrium::contact_above_centre);
  for (const auto& points : {Points{{0, 0, 0}}, Points{{.1, 0, 0}, {1, 0, 0}, {1, 1, 0}}, socket}) {
    const auto result = tipping(mass, points);
    EXPECT_TRUE(result.edges.empty());
    EXPECT_TRUE(result.a_qs_g_by_azimuth.empty());
    EXPECT_FALSE(result.critical);
    EXPECT_STRNE(reason_of(result.equilibrium), "");
  }
  EXPECT_LT(tipping(mass, Points{{.1, 0, 0}, {1, 0, 0}, {1, 1, 0}}).plumb_margin, 0.0);
}

TEST(Tipping, RefusesInvertedMassAndBrokenPoints) {
  auto inward = exact_block(1, 1, 1);
  inward.volume = -inward.volume;
  EXPECT_THROW((void)tipping(inward, rectangle(1, 1, 0)), base::Error);
  auto points = rectangle(1, 1, 0);
  points[2].z() = std::nan("");
  EXPECT_THROW((void)tipping(exact_block(1, 1, 1), points), base::Error);
}

TEST(Tipping, ConcaveOutlineAndManyPointsCountAsTheirHull) {
  const auto mass = exact_block(1, 1, 3);
  Points points = rectangle(1, 1, 0);
  points.emplace_back(0.3, 0.0, 0.0);
  for (int i = 1; i < 1000; ++i) points.emplace_back(-0.5 + i * 1e-3, 0.5, 0.0);
  const auto result = tipping(mass, points);
  EXPECT_EQ(result.edges.size(), 4U);
  EXPECT_NEAR(result.edges[*result.critical].alpha, std::atan(1.0 / 3.0), kExact);
}

}  // namespace
}  // namespace cairn::fragility
