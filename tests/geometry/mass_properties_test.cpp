#include "geometry/mass_properties.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/bodies.hpp"

namespace cairn::geometry {
namespace {

using namespace cairn::testing;

constexpr double kPolyhedron = 1e-8;  // relative: the figure issue and reference ask for
constexpr double kOffset = 1e-9;      // relative, after a UTM offset
constexpr double kRoundOff = 1e-12;   // relative: sums of a few dozen terms
const Vec3 kUtm(500000.0, 3.8e6, 1500.0);

double relative(const Mat3& found, const Mat3& expected) {
  return (found - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff();
}

void expect_same(const MassProperties& found, const MassProperties& expected, double tolerance) {
  const double size = std::cbrt(std::abs(expected.volume));
  EXPECT_NEAR(found.volume, expected.volume, tolerance * std::abs(expected.volume));
  EXPECT_LT((found.centre_of_mass - expected.centre_of_mass).norm(), tolerance * size);
  EXPECT_LT(relative(found.inertia_per_density, expected.inertia_per_density), tolerance);
}

TEST(MassProperties, BlocksOfTheReferenceTable) {
  struct Row {
    double w, d, h, volume, inertia_per_mass;
  };
  // Section 6.2: V and I_cm/m about the axis along d.
  for (const Row& row :
       {Row{1, 1, 3, 3.0, 0.83333333}, Row{2, 1, 3, 6.0, 1.08333333}, Row{.5, .5, 1.5, .375, .20833333}}) {
    const auto m = mass_properties(block(row.w, row.d, row.h));
    expect_same(m, exact_block(row.w, row.d, row.h), kRoundOff);
    EXPECT_NEAR(m.volume, row.volume, kPolyhedron * row.volume);
    EXPECT_NEAR(m.inertia_per_density(1, 1) / m.volume, row.inertia_per_mass, 5e-9);  // printed digits
    EXPECT_NEAR(m.area, 2 * (row.w * row.d + row.w * row.h + row.d * row.h), kRoundOff * 20);
  }
}

TEST(MassProperties, ShearedPrismMovesHalfTheShear) {
  const auto straight = mass_properties(block(1, 2, 3));
  const auto sheared = mass_properties(prism({{-.5, -1}, {.5, -1}, {.5, 1}, {-.5, 1}}, 3, {0.8, -0.3}));
  EXPECT_NEAR(sheared.volume, straight.volume, kPolyhedron);
  EXPECT_LT((sheared.centre_of_mass - straight.centre_of_mass - Vec3(0.4, -0.15, 0)).norm(), kPolyhedron);
  // Sections shift linearly with z: Int x'z' = shear_x Int z'^2 / h, with sign -Int xz.
  EXPECT_NEAR(sheared.inertia_per_density(0, 2), -0.8 / 3 * 6 * 9 / 12.0, kPolyhedron);
  EXPECT_NEAR(sheared.inertia_per_density(1, 2), 0.3 / 3 * 6 * 9 / 12.0, kPolyhedron);
}

TEST(MassProperties, LShapeIsTheSumOfItsBoxes) {
  // Box A 2 x 1, box B 1 x 1 on top of its left end in plan; height 1.5. First vertex = reflex corner.
  const auto m = mass_properties(prism({{1, 1}, {1, 2}, {0, 2}, {0, 0}, {2, 0}, {2, 1}}, 1.5));
  MassProperties sum;
  const std::vector<std::pair<Vec3, Vec3>> boxes = {{{2, 1, 1.5}, {1, .5, .75}}, {{1, 1, 1.5}, {.5, 1.5, .75}}};
  for (const auto& [size, centre] : boxes) {
    const double v = size.prod();
    sum.volume += v;
    sum.centre_of_mass += v * centre;
  }
  sum.centre_of_mass /= sum.volume;
  for (const auto& [size, centre] : boxes) {
    const double v = size.prod();
    const Vec3 r = centre - sum.centre_of_mass;
    sum.inertia_per_density += exact_block(size.x(), size.y(), size.z()).inertia_per_density +
                               v * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
  }
  expect_same(m, sum, kPolyhedron);
}

TEST(MassProperties, RegularPrisms) {
  for (const int n : {3, 5, 6, 12}) {
    const double r = 0.7, h = 2.0;
    const auto m = mass_properties(prism(regular_polygon(n, r, 0.3), h));
    const double step = 2 * std::numbers::pi / n;
    const double area = 0.5 * n * r * r * std::sin(step);
    // Second moment of a regular polygon: equal about every axis in its plane.
    const double polar = n * std::pow(r, 4) / 12.0 * std::sin(step) * (2 + std::cos(step));
    MassProperties exact;
    exact.volume = area * h;
    exact.centre_of_mass = {0, 0, h / 2};
    const double transverse = polar / 2 * h + area * h * h * h / 12;
    exact.inertia_per_density = Vec3(transverse, transverse, polar * h).asDiagonal();
    expect_same(m, exact, kPolyhedron);
  }
}

struct Curved {
  const char* name;
  MassProperties exact;
  std::function<TriangleMesh(int)> mesh;
  double volume, height, inertia_per_mass;  // section 6.2, printed digits (I about x)
  double base;                              // z of the flat base
};

class CurvedBody : public ::testing::TestWithParam<Curved> {};

TEST_P(CurvedBody, ExactFormulaGivesThePrintedDigits) {
  const auto& body = GetParam();
  EXPECT_NEAR(body.exact.volume, body.volume, 5.1e-9);
  EXPECT_NEAR(body.exact.centre_of_mass.z() - body.base, body.height, 5.1e-9);
  EXPECT_NEAR(body.exact.inertia_per_density(0, 0) / body.exact.volume, body.inertia_per_mass, 5.1e-9);
}

TEST_P(CurvedBody, ConvergesAtSecondOrderWithFacetSize) {
  const auto& body = GetParam();
  const auto errors = [&](int around) {
    const auto mesh = body.mesh(around);
    EXPECT_TRUE(topology(mesh).closed());
    const auto m = mass_properties(mesh);
    return std::array<double, 3>{m.volume - body.exact.volume, m.centre_of_mass.z() - body.exact.centre_of_mass.z(),
                                 m.inertia_per_density(0, 0) - body.exact.inertia_per_density(0, 0)};
  };
  const auto coarse = errors(64), fine = errors(128);
  for (std::size_t k = 0; k < 3; ++k) {
    const double scale = body.exact.volume;
    EXPECT_LT(std::abs(fine[k]), 2e-3 * scale) << k;
    if (std::abs(coarse[k]) < 1e-12 * scale) continue;  // exact by symmetry (height of a cylinder)
    EXPECT_NEAR(coarse[k] / fine[k], 4.0, 0.05) << k;
    // One step of Richardson extrapolation removes the second-order term.
    EXPECT_NEAR((4 * fine[k] - coarse[k]) / 3, 0.0, 2e-6 * scale) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Reference, CurvedBody,
    ::testing::Values(
        Curved{"cylinder", exact_frustum(.5, .5, 3), [](int n) { return frustum(.5, .5, 3, n); }, 2.35619449, 1.5,
               .8125, 0},
        Curved{"frustum", exact_frustum(.3, .8, 2), [](int n) { return frustum(.3, .8, 2, n); }, 2.03156325, 1.28350515,
               .37073307, 0},
        Curved{"cone", exact_frustum(.5, 0, 2), [](int n) { return frustum(.5, 0, 2, n); }, .52359878, .5, .1875, 0},
        Curved{"truncated_ellipsoid", exact_truncated_ellipsoid(1, .8, 1.2, .9),
               [](int n) { return truncated_ellipsoid(1, .8, 1.2, .9, n); }, 3.84845100, .945, .385175, -.9},
        Curved{"truncated_sphere", exact_truncated_ellipsoid(1, 1, 1, .8),
               [](int n) { return truncated_ellipsoid(1, 1, 1, .8, n); }, 4.07150408, .825, .387375, -.8},
        Curved{"hemisphere", exact_truncated_ellipsoid(1, 1, 1, 0),
               [](int n) { return truncated_ellipsoid(1, 1, 1, 0, n); }, 2.09439510, .375, .259375, 0}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(MassProperties, FrustumAboutItsAxis) {
  const auto m = exact_frustum(.3, .8, 2);
  EXPECT_NEAR(m.inertia_per_density(2, 2) / m.volume, .20118557, 5.1e-9);
}

TEST(MassProperties, UtmOffsetCostsNoDigits) {
  // An asymmetric body with inexact coordinates; the offset itself rounds each vertex by up to 2.3e-10 m.
  const auto mesh = truncated_ellipsoid(1, .8, 1.2, .9, 40);
  auto expected = mass_properties(mesh);
  const auto found = mass_properties(moved(mesh, kUtm));
  expected.centre_of_mass += kUtm;
  EXPECT_NEAR(found.volume, expected.volume, kOffset * expected.volume);
  EXPECT_LT((found.centre_of_mass - expected.centre_of_mass).norm(), kOffset);
  EXPECT_LT(relative(found.inertia_per_density, expected.inertia_per_density), kOffset);
}

TEST(MassProperties, ScaleYawSubdivisionAndFlip) {
  const auto mesh = prism({{1, 1}, {1, 2}, {0, 2}, {0, 0}, {2, 0}, {2, 1}}, 1.5, {0.4, 0.1});
  const auto m = mass_properties(mesh);
  const double s = 0.3048;
  const auto feet = mass_properties(moved(mesh, Vec3::Zero(), 0.0, s));
  EXPECT_NEAR(feet.volume, m.volume * std::pow(s, 3), kRoundOff);
  EXPECT_LT(relative(feet.inertia_per_density, m.inertia_per_density * std::pow(s, 5)), kRoundOff);
  expect_same(mass_properties(subdivided(subdivided(mesh))), m, kRoundOff);
  const auto turned = mass_properties(moved(mesh, Vec3::Zero(), 0.7));
  EXPECT_NEAR(turned.volume, m.volume, kRoundOff * m.volume);
  EXPECT_NEAR(turned.inertia_per_density.trace(), m.inertia_per_density.trace(), kRoundOff * 100);
  EXPECT_NEAR(turned.inertia_per_density(2, 2), m.inertia_per_density(2, 2), kRoundOff * 100);
  const auto inward = mass_properties(flipped(mesh));
  EXPECT_DOUBLE_EQ(inward.volume, -m.volume);
  EXPECT_LT((inward.centre_of_mass - m.centre_of_mass).norm(), kRoundOff);
}

TEST(MassProperties, EmptyMeshHasNoMass) {
  EXPECT_EQ(mass_properties(TriangleMesh{}).volume, 0.0);
}

}  // namespace
}  // namespace cairn::geometry
