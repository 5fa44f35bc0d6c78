#include "dynamics/rigid_rock.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.hpp"
#include "support/bodies.hpp"

namespace cairn::dynamics {
namespace {

using geometry::Vec3;

const std::vector<Vec3> kSquare = {{-0.5, -0.5, 0}, {0.5, -0.5, 0}, {0.5, 0.5, 0}, {-0.5, 0.5, 0}};

TEST(RigidRock, CarriesTheMeshsOwnMassProperties) {
  const auto mesh = testing::block(1, 1, 3);
  const auto mass = geometry::mass_properties(mesh);
  const auto rock = rigid_rock(mesh, mass, 2600.0, kSquare);
  EXPECT_DOUBLE_EQ(rock.mass_kg, 7800.0);
  EXPECT_TRUE(rock.centre_of_mass_m.isApprox(Vec3(0, 0, 1.5)));
  // fragility.md 6.2: I_cm/m = .83333333
  EXPECT_NEAR(rock.inertia_kg_m2(0, 0) / rock.mass_kg, 0.83333333, 1e-8);
}

TEST(RigidRock, KeepsTheCornersThatBear) {
  auto contacts = kSquare;
  contacts.emplace_back(0.1, 0.2, 0.0);  // inside
  contacts.emplace_back(0.5, 0.0, 0.0);  // on an edge
  contacts.emplace_back(0.5, 0.5, 0.0);  // twice
  const auto mesh = testing::block(1, 1, 3);
  const auto rock = rigid_rock(mesh, geometry::mass_properties(mesh), 2600.0, contacts);
  EXPECT_EQ(rock.foot_m.size(), 4U);
  EXPECT_TRUE(rock.pad_normal.isApprox(Vec3::UnitZ()));
  EXPECT_LT(rock.foot_off_plane_m, 1e-12);
}

// fragility.md 7.2: four contacts of uneven height. The raised one bears: in the central projection it lies outside
// the hull of the others only where it must.
TEST(RigidRock, ChoosesTheCornersOfAnUnevenContactByCentralProjection) {
  geometry::MassProperties mass;
  mass.volume = 1.0;
  mass.centre_of_mass = {0, 0, 2};
  mass.inertia_per_density = geometry::Mat3::Identity();
  const std::vector<Vec3> contacts = {{1, -.6, 0}, {-.5, -.8, 0}, {-.5, .9, 0}, {0, .05, .5}};
  EXPECT_EQ(rigid_rock({}, mass, 1.0, contacts).foot_m.size(), 3U);
  const std::vector<Vec3> raised = {{1, -.6, 0}, {-.5, -.8, 0}, {-.5, .9, 0}, {0.9, .6, 1.0}};
  const auto rock = rigid_rock({}, mass, 1.0, raised);
  EXPECT_EQ(rock.foot_m.size(), 4U);
  EXPECT_GT(rock.foot_off_plane_m, 0.01);
}

TEST(RigidRock, SlicesFollowTheFlanksAndStartAboveThePads) {
  const auto mesh = testing::frustum(0.3, 0.8, 2.0, 64);
  RigidRockOptions options;
  options.clearance_m = 0.02;
  const auto rock = rigid_rock(mesh, geometry::mass_properties(mesh), 2600.0,
                               std::vector<Vec3>(mesh.vertices.begin(), mesh.vertices.begin() + 64), options);
  ASSERT_EQ(rock.pieces_m.size(), 8U);
  for (const auto& piece : rock.pieces_m)
    for (const auto& p : piece) {
      EXPECT_GE(p.z(), 0.02 - 1e-9);
      EXPECT_LE(p.head<2>().norm(), 0.3 + 0.25 * p.z() + 1e-9);  // radius at that height
    }
}

TEST(RigidRock, RefusesAContactThatCannotHold) {
  const auto mesh = testing::block(1, 1, 3);
  const auto mass = geometry::mass_properties(mesh);
  const auto refused = [&](const std::vector<Vec3>& contacts) {
    EXPECT_THROW((void)rigid_rock(mesh, mass, 2600.0, contacts), base::Error);
  };
  refused({});
  refused({{0, 0, 0}});
  refused({{-0.5, 0, 0}, {0.5, 0, 0}, {0.0, 0, 0}});            // a line
  refused({{0.1, -0.5, 0}, {0.5, -0.5, 0}, {0.5, 0.5, 0}});     // plumb point outside
  refused({{-0.5, -0.5, 0}, {0.5, -0.5, 0}, {0.0, 0.5, 2.0}});  // above the centre of mass
  EXPECT_THROW((void)rigid_rock(mesh, mass, 0.0, kSquare), base::Error);
}

}  // namespace
}  // namespace cairn::dynamics
