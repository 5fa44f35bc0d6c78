// Published meshes with published or independently computed mass properties (tests/data/pbr_meshes/README.md).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "geometry/mass_properties.hpp"
#include "io/obj.hpp"
#include "support/bodies.hpp"
#include "support/data.hpp"
#include "surface/mesh_checks.hpp"
#include "surface/rock_body.hpp"

namespace cairn::surface {
namespace {

using namespace cairn::testing;
using geometry::mass_properties;

constexpr double kTenDigits = 5.1e-11;  // half a unit of the last printed digit
const Vec3 kUtm(500000.0, 3.8e6, 1500.0);

TriangleMesh read(const std::string& name) {
  return io::read_obj_mesh(test_data("pbr_meshes/" + name)).mesh;
}

TEST(PublishedMeshes, DoubleRockToEveryDigit) {
  const auto mesh = read("closed_pbr.obj");
  EXPECT_EQ(mesh.vertices.size(), 20140U);
  EXPECT_EQ(mesh.triangles.size(), 40276U);
  EXPECT_TRUE(geometry::topology(mesh).closed());
  const auto m = mass_properties(mesh);
  EXPECT_NEAR(m.volume, .5529217019, kTenDigits);
  EXPECT_NEAR(m.centre_of_mass.x(), -2.2e-7, 5.1e-9);
  EXPECT_NEAR(m.centre_of_mass.y(), -4.5e-7, 5.1e-9);
  EXPECT_NEAR(m.centre_of_mass.z(), 2.7e-7, 5.1e-9);
  const double density = 2600;
  const Mat3 inertia = density * m.inertia_per_density;
  // Published to three decimals (the mass too), recomputed to four.
  constexpr double kThree = 5.1e-4, kFour = 5.1e-5;
  EXPECT_NEAR(density * m.volume, 1437.596, kThree);
  EXPECT_NEAR(density * m.volume, 1437.5964, kFour);
  const std::vector<std::tuple<int, int, double, double>> published = {
      {0, 0, 260.473, 260.4733}, {0, 1, -12.88, -12.8797}, {0, 2, -83.689, -83.6891},
      {1, 1, 313.424, 313.4235}, {1, 2, -26.81, -26.8100}, {2, 2, 134.045, 134.0447}};
  for (const auto& [i, j, three, four] : published) {
    EXPECT_NEAR(inertia(i, j), three, kThree) << i << j;
    EXPECT_NEAR(inertia(i, j), four, kFour) << i << j;
    EXPECT_EQ(inertia(i, j), inertia(j, i));
  }
  const Vec3 size = mesh.bounds().size();
  EXPECT_LT((size - Vec3(1.238, .754, 1.509)).cwiseAbs().maxCoeff(), kThree);
}

TEST(PublishedMeshes, DoubleRockFarFromTheOrigin) {
  const auto mesh = read("closed_pbr.obj");
  const auto here = mass_properties(mesh), there = mass_properties(moved(mesh, kUtm));
  // The offset rounds each of 20,140 vertices at random by up to 2.3e-10 m; volumes average that out.
  EXPECT_NEAR(there.volume / here.volume, 1.0, 1e-9);
  EXPECT_LT((there.centre_of_mass - here.centre_of_mass - kUtm).norm(), 1e-9);
  EXPECT_LT((there.inertia_per_density - here.inertia_per_density).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(PublishedMeshes, DoubleRockAsABody) {
  const auto result = body_of(read("closed_pbr.obj"));
  const auto* body = std::get_if<RockBody>(&result);
  ASSERT_NE(body, nullptr) << std::get<base::Reject>(result).reason << std::get<base::Reject>(result).message;
  // As published it passes through itself somewhere: said, not hidden.
  EXPECT_TRUE(body->quality.topology.closed());
  EXPECT_TRUE(body->quality.self_intersecting);
  EXPECT_FALSE(body->quality.watertight);
  EXPECT_THAT(body->notes, ::testing::Contains("self_intersecting"));
  EXPECT_GT(body->hull_volume, body->mass.volume);
  EXPECT_LT(body->hull_volume, 1.238 * .754 * 1.509);
}

TEST(PublishedMeshes, SpecimenSp1) {
  const auto mesh = read("final_sp1.obj");
  EXPECT_EQ(mesh.vertices.size(), 5576U);
  EXPECT_EQ(mesh.triangles.size(), 11148U);
  EXPECT_TRUE(geometry::topology(mesh).closed());
  const auto m = mass_properties(mesh);
  EXPECT_NEAR(m.volume, .1225086807, kTenDigits);
  const std::vector<std::tuple<int, int, double>> expected = {{0, 0, .00741022358},  {1, 1, .00643820312},
                                                              {2, 2, .00548172868},  {0, 1, -.00054638301},
                                                              {0, 2, -.00201708756}, {1, 2, -.00029162156}};
  for (const auto& [i, j, value] : expected) EXPECT_NEAR(m.inertia_per_density(i, j), value, 5.1e-12) << i << j;
  EXPECT_LT((mesh.bounds().size() - Vec3(.6700, .7600, .7900)).cwiseAbs().maxCoeff(), 5.1e-5);
}

TEST(PublishedMeshes, UnweldedCopyInPrincipalAxes) {
  const auto split = read("granite_sp1_pca.obj");
  EXPECT_EQ(split.vertices.size(), 32227U);
  EXPECT_EQ(geometry::topology(split).boundary_edges, 32276U);
  EXPECT_NEAR(mass_properties(split).volume, .1225086806, kTenDigits);
  const auto mesh = geometry::weld(split);
  EXPECT_EQ(mesh.vertices.size(), 5576U);
  EXPECT_TRUE(geometry::topology(mesh).closed());
  const auto m = mass_properties(mesh);
  EXPECT_NEAR(m.volume, .1225086806, kTenDigits);
  EXPECT_NEAR(m.inertia_per_density(0, 0), .00408609817, 5.1e-12);
  EXPECT_NEAR(m.inertia_per_density(1, 1), .00652002511, 5.1e-12);
  EXPECT_NEAR(m.inertia_per_density(2, 2), .00872403209, 5.1e-12);
  EXPECT_LT((mesh.bounds().size() - Vec3(.9809, .7724, .4081)).cwiseAbs().maxCoeff(), 5.1e-5);
  // The same body as final_sp1.obj: equal principal moments, whatever the axes.
  const Eigen::SelfAdjointEigenSolver<Mat3> other(mass_properties(read("final_sp1.obj")).inertia_per_density);
  EXPECT_LT((other.eigenvalues() - m.inertia_per_density.diagonal()).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(PublishedMeshes, InsideOutAndFarFromTheOrigin) {
  const auto raw = read("SP1.obj");
  EXPECT_EQ(raw.vertices.size(), 14335U);
  EXPECT_EQ(raw.triangles.size(), 28666U);
  // In exact rational arithmetic: -0.12385956453557778 (the reference prints -.1238595646).
  EXPECT_NEAR(mass_properties(raw).volume, -.12385956453557778, 1e-13);
  const auto mesh = geometry::weld(raw);
  EXPECT_EQ(mesh.vertices.size(), 14334U);
  EXPECT_EQ(mesh.triangles.size(), 28664U);  // two degenerate faces dropped
  EXPECT_TRUE(geometry::topology(mesh).closed());
  const auto result = body_of(raw);
  const auto* body = std::get_if<RockBody>(&result);
  ASSERT_NE(body, nullptr) << std::get<base::Reject>(result).reason;
  EXPECT_THAT(body->notes, ::testing::Contains("turned_outwards"));
  EXPECT_NEAR(body->mass.volume, .12385956453557778, 1e-13);
  EXPECT_LT((body->mass.centre_of_mass - Vec3(1.80, 51.74, 311.9)).cwiseAbs().maxCoeff(), 0.051);
}

TEST(PublishedMeshes, Block) {
  const auto mesh = geometry::weld(read("merge_block_Final.obj"));
  EXPECT_TRUE(geometry::topology(mesh).closed());
  const auto m = mass_properties(mesh);
  EXPECT_NEAR(m.volume, .375, kTenDigits);
  EXPECT_NEAR(m.centre_of_mass.z(), .75, kTenDigits);
  EXPECT_LT((m.inertia_per_density.diagonal() - Vec3(.078125, .078125, .015625)).cwiseAbs().maxCoeff(), kTenDigits);
}

}  // namespace
}  // namespace cairn::surface
