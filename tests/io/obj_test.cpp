#include "io/obj.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "geometry/mass_properties.hpp"
#include "io/ply.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using geometry::Triangle;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

MeshData parse(const std::string& content) {
  const testing::TempFolder folder;
  base::write_file(folder / "a.obj", content);
  return read_obj_mesh(folder / "a.obj");
}

const std::string kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

TEST(Obj, AllCornerFormsAndPolygons) {
  const std::vector<Triangle> two = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_EQ(parse(kSquare + "f 1 2 3 4\n").mesh.triangles, two);
  EXPECT_EQ(parse(kSquare + "f 1/1 2/2 3/3 4/4\n").mesh.triangles, two);
  EXPECT_EQ(parse(kSquare + "f 1//1 2//2 3//3 4//4\n").mesh.triangles, two);
  EXPECT_EQ(parse(kSquare + "f 1/1/1 2/2/1 3/3/1 4/4/1 # a quad\r\n").mesh.triangles, two);
  EXPECT_EQ(parse(kSquare + "f -4 -3 -2 -1\n").mesh.triangles, two);
  EXPECT_EQ(parse(kSquare + "f 1 2 \\\n3 4\n").mesh.triangles, two);
  EXPECT_EQ(parse("f 1 2 3 4\n" + kSquare).mesh.triangles, two);
}

TEST(Obj, NegativeIndicesCountFromTheFaceNotFromTheEnd) {
  EXPECT_THAT(parse("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 9 9 9\n").mesh.triangles, ElementsAre(Triangle{0, 1, 2}));
}

TEST(Obj, ColoursInBothHabitsAndWeights) {
  const MeshData unit = parse("v 0 0 0 1 0.5 0\nv 1 0 0 0 0 1\nv 0 1 0 0 0 0\nf 1 2 3\n");
  EXPECT_THAT(unit.mesh.colours[0], ElementsAre(255, 128, 0));
  const MeshData bytes = parse("v 0 0 0 255 128 0\nv 1 0 0 0 0 1\nv 0 1 0 0 0 0\nf 1 2 3\n");
  EXPECT_THAT(bytes.mesh.colours[0], ElementsAre(255, 128, 0));
  EXPECT_EQ(parse("v 1 2 3 1.0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").mesh.vertices[0], geometry::Vec3(1, 2, 3));
}

TEST(Obj, NeverOpensItsMaterialLibrary) {
  const MeshData mesh = parse("mtllib ../../../../etc/passwd\n" + kSquare + "usemtl a\nf 1 2 3\n");
  EXPECT_EQ(mesh.mesh.triangles.size(), 1U);
  EXPECT_THAT(mesh.facts.warnings, ElementsAre(HasSubstr("not opened")));
}

TEST(Obj, ComesBackBitForBitUnderAUtmOffset) {
  const testing::TempFolder folder;
  geometry::TriangleMesh mesh;
  mesh.vertices = {{576661.97123456789, 5188114.06123456789, 1.0 / 3.0}, {-0.1, 1e-20, 3}, {0, 1, 0}};
  mesh.triangles = {{2, 1, 0}};
  mesh.colours = {{0, 1, 2}, {100, 128, 254}, {255, 77, 3}};
  write_obj(folder / "a.obj", mesh, {{"line one\nline two"}});
  const MeshData back = read_obj_mesh(folder / "a.obj");
  EXPECT_EQ(back.mesh.vertices, mesh.vertices);
  EXPECT_EQ(back.mesh.triangles, mesh.triangles);
  EXPECT_EQ(back.mesh.colours, mesh.colours);
}

// Mass properties of a scanned rock are the same in UTM coordinates, through both formats. The rock is
// open at its base, so its "volume" is only a number; it must not depend on the offset.
TEST(Obj, ARealRockKeepsItsVolumeInUtm) {
  // Coordinates near 5e6 m have steps of 9e-10 m: relative to a rock of decimetres 1e-8.
  constexpr double kRelative = 1e-7;
  const testing::TempFolder folder;
  const MeshData rock = read_obj_mesh(testing::test_data("polar_rocks/terrain01_rock6_decimate-005.obj"));
  ASSERT_GT(rock.mesh.triangles.size(), 50U);
  const double volume = geometry::mass_properties(rock.mesh).volume;
  geometry::TriangleMesh moved = rock.mesh;
  for (auto& p : moved.vertices) p += geometry::Vec3(576661.97, 5188114.06, 156.06);
  write_obj(folder / "a.obj", moved);
  write_ply(folder / "a.ply", moved);
  EXPECT_NEAR(geometry::mass_properties(read_obj_mesh(folder / "a.obj").mesh).volume, volume,
              kRelative * std::abs(volume));
  EXPECT_NEAR(geometry::mass_properties(read_ply_mesh(folder / "a.ply").mesh).volume, volume,
              kRelative * std::abs(volume));
}

TEST(Obj, Samples) {
  const auto box = read_obj_mesh(testing::test_data("pdal_samples/obj/box.obj"));
  EXPECT_EQ(box.mesh.triangles.size(), 12U);
  EXPECT_TRUE(geometry::topology(box.mesh).closed());
  EXPECT_NEAR(geometry::mass_properties(box.mesh).volume, 1.0, 1e-12);  // unit cube, rounding
  EXPECT_EQ(read_obj_cloud(testing::test_data("pdal_samples/obj/box.obj")).cloud.size(), 8U);
  EXPECT_THROW((void)read_obj_mesh(testing::test_data("pdal_samples/obj/no_vertex.obj")), base::Error);
}

void expect_refused(const std::string& content, const std::string& record, const std::string& message) {
  try {
    (void)parse(content);
    FAIL() << "accepted: " << content;
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::invalid_input);
    EXPECT_EQ(error.record(), record);
    EXPECT_THAT(error.what(), HasSubstr(message));
  }
}

TEST(Obj, BadInputIsNamedByLine) {
  expect_refused(kSquare + "f 1 2 5\n", "line 5", "does not exist");
  expect_refused(kSquare + "f 1 2 0\n", "line 5", "does not exist");
  expect_refused(kSquare + "f 1 2 -5\n", "line 5", "does not exist");
  expect_refused(kSquare + "f 1 2 99999999999999999999\n", "line 5", "not a vertex number");
  expect_refused(kSquare + "f 1 2 x\n", "line 5", "not a vertex number");
  expect_refused("v 1 2\n", "line 1", "fewer than 3");
  expect_refused("v 1 2 three\n", "line 1", "not a number");
  expect_refused(
      "\x7f"
      "ELF\n",
      "line 1", "not an OBJ file");
  expect_refused("hello world\n", "line 1", "not an OBJ file");
}

TEST(Obj, DropsFacesOfVerticesThatAreNotFinite) {
  const MeshData mesh = parse("v nan 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 2 3 4\nf 1 2\n");
  EXPECT_EQ(mesh.mesh.vertices.size(), 3U);
  EXPECT_THAT(mesh.mesh.triangles, ElementsAre(Triangle{0, 1, 2}));
  EXPECT_EQ(mesh.facts.dropped_faces, 2U);
}

}  // namespace
}  // namespace cairn::io
