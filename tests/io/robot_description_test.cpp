#include "io/robot_description.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "base/error.hpp"
#include "io/obj.hpp"
#include "support/bodies.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using geometry::Vec3;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<std::string> reasons(const RobotLink& link, const geometry::TriangleMesh& mesh) {
  std::vector<std::string> out;
  for (const auto& f : link_findings(link, mesh)) out.push_back(f.reason);
  return out;
}

RobotLink diagonal(double mass_kg, double ixx, double iyy, double izz) {
  RobotLink link;
  link.name = "rock";
  link.mass_kg = mass_kg;
  link.inertia_kg_m2 = Vec3(ixx, iyy, izz).asDiagonal();
  return link;
}

geometry::TriangleMesh pbr_mesh(const char* name) {
  return geometry::weld(read_obj_mesh(cairn::testing::test_data("pbr_meshes") / name).mesh);
}

// Double Rock far from the origin: what is written reads back as the published body in both formats.
TEST(RobotModel, WritesConsistentUrdfAndSdf) {
  const auto mesh = cairn::testing::moved(pbr_mesh("closed_pbr.obj"), Vec3(500000, 3.8e6, 1500));
  const cairn::testing::TempFolder folder;
  write_robot_model(folder.path(), mesh, geometry::mass_properties(mesh), {"double <rock> & \"co\"", 2600.0, 0.5, 0.1});
  const auto written = read_obj_mesh(folder / "mesh.obj").mesh;
  EXPECT_LT(geometry::mass_properties(written).centre_of_mass.norm(), 1e-6);
  for (const char* name : {"model.urdf", "model.sdf"}) {
    const auto description = read_robot_description(folder / name);
    EXPECT_EQ(description.name, "double <rock> & \"co\"");
    ASSERT_EQ(description.links.size(), 1U);
    const RobotLink& link = description.links.front();
    // Published with the mesh (fragility.md 4.1), to their digits.
    EXPECT_NEAR(link.mass_kg, 1437.596, 2e-3);
    EXPECT_NEAR(link.inertia_kg_m2(0, 0), 260.473, 2e-3);
    EXPECT_NEAR(link.inertia_kg_m2(0, 1), -12.88, 1e-2);
    EXPECT_NEAR(link.inertia_kg_m2(2, 0), -83.689, 2e-3);
    EXPECT_NEAR(link.inertia_kg_m2(1, 1), 313.424, 2e-3);
    EXPECT_NEAR(link.inertia_kg_m2(1, 2), -26.81, 1e-2);
    EXPECT_NEAR(link.inertia_kg_m2(2, 2), 134.045, 2e-3);
    EXPECT_EQ(link.T_link_inertial.translation, Vec3(0, 0, 0));
    EXPECT_THAT(link.meshes, ElementsAre("mesh.obj"));
    EXPECT_THAT(reasons(link, written), IsEmpty());
  }
}

TEST(RobotModel, GivesTheSameBytes) {
  const auto mesh = cairn::testing::block(0.5, 0.5, 1.5);
  const cairn::testing::TempFolder a, b;
  for (const auto* folder : {&a, &b}) write_robot_model(folder->path(), mesh, geometry::mass_properties(mesh), {});
  for (const char* name : {"model.urdf", "model.sdf", "model.config", "mesh.obj"}) {
    std::ifstream first(a / name), second(b / name);
    const std::string one((std::istreambuf_iterator<char>(first)), {}),
        two((std::istreambuf_iterator<char>(second)), {});
    EXPECT_FALSE(one.empty());
    EXPECT_EQ(one, two);
  }
}

// Published descriptions whose figures do not belong together (fragility.md 4.2).
TEST(LinkFindings, CatchesThePublishedInconsistencies) {
  const auto sp1_principal = pbr_mesh("granite_sp1_pca.obj");
  const auto sp1 = pbr_mesh("final_sp1.obj");
  const auto block = pbr_mesh("merge_block_Final.obj");
  // SP1: inertia of a body of 330.77 kg, 6.3 % low for its mass.
  EXPECT_THAT(reasons(diagonal(353.00, 11.032465, 17.604068, 23.554887), sp1_principal),
              ElementsAre("inertia_not_the_mesh"));
  // What it should have been.
  EXPECT_THAT(reasons(diagonal(353.00, 11.774, 18.787, 25.138), sp1_principal), IsEmpty());
  // SP2: the factor 1/V is missing, 8 times too small.
  EXPECT_THAT(reasons(diagonal(353.46, 2.68327252, 2.29631331, 1.97878238), sp1),
              ElementsAre("inertia_not_the_box", "inertia_not_the_mesh"));
  // Block: Double Rock's mass and inertia.
  auto wrong = diagonal(1437.596, 260.473, 313.424, 134.045);
  wrong.inertia_kg_m2(0, 1) = wrong.inertia_kg_m2(1, 0) = -12.88;
  wrong.inertia_kg_m2(0, 2) = wrong.inertia_kg_m2(2, 0) = -83.689;
  wrong.inertia_kg_m2(1, 2) = wrong.inertia_kg_m2(2, 1) = -26.81;
  EXPECT_THAT(reasons(wrong, block), ElementsAre("inertia_not_the_mesh", "density_not_a_rock"));
  EXPECT_THAT(reasons(diagonal(0.375 * 2600, 203.125, 203.125, 40.625), block), IsEmpty());
  // A placeholder.
  EXPECT_THAT(reasons(diagonal(10.0, 0.1, 0.1, 0.1), sp1),
              ElementsAre("inertia_not_the_box", "inertia_not_the_mesh", "density_not_a_rock"));
  // No body has one moment above the sum of the others.
  EXPECT_THAT(reasons(diagonal(353.0, 5.0, 5.0, 25.0), sp1_principal),
              ElementsAre("inertia_not_a_body", "inertia_not_the_mesh"));
}

class HostileDescription : public ::testing::TestWithParam<const char*> {};

TEST_P(HostileDescription, IsRefusedWithTheFile) {
  const cairn::testing::TempFolder folder;
  const auto file = folder / "model.urdf";
  std::ofstream(file) << GetParam();
  try {
    (void)read_robot_description(file);
    FAIL();
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::invalid_input);
    EXPECT_EQ(error.file(), file.string());
  }
}

INSTANTIATE_TEST_SUITE_P(
    Files, HostileDescription,
    ::testing::Values(
        "", "<robot", "<html/>", "<robot name='a'/>", "<sdf version='1.7'/>", "<robot><link name='a'/></robot>",
        "<robot><link><inertial><mass value='x'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' "
        "izz='1'/></inertial></link></robot>",
        "<robot><link><inertial><mass value='nan'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' "
        "izz='1'/></inertial></link></robot>",
        "<robot><link><inertial><mass value='1'/><inertia ixx='1'/></inertial></link></robot>",
        "<robot><link><inertial><origin xyz='0 0'/><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' "
        "izz='1'/></inertial></link></robot>"));

}  // namespace
}  // namespace cairn::io
