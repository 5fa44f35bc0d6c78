#include "io/ply.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using geometry::PointCloud;
using geometry::ScalarType;
using ::testing::HasSubstr;

std::filesystem::path pdal(std::string_view name) {
  return testing::test_data("pdal_samples/ply") / name;
}

PointCloud small_cloud() {
  PointCloud cloud;
  cloud.positions = {{576661.97123456789, 5188114.06123456789, 156.06}, {576661.98, 5188114.07, 156.07}};
  cloud.normals = {{0, 0, 1}, {1, 0, 0}};
  cloud.colours = {{0, 257, 65535}, {257 * 7, 257 * 8, 257 * 9}};
  cloud.intensity = {7, 65535};
  cloud.classification = {2, 255};
  cloud.gps_time = {1.5, 284371.25};
  cloud.add_scalar("target_id", ScalarType::u32, "").values = {0, 4294967295.0};
  cloud.add_scalar("hag", ScalarType::f32, "").values = {-0.5, 1e30F};
  cloud.add_scalar("i8", ScalarType::i8, "").values = {-128, 127};
  return cloud;
}

TEST(Ply, CloudComesBackBitForBit) {
  const testing::TempFolder folder;
  const PointCloud cloud = small_cloud();
  write_ply(folder / "a.ply", cloud, {"EPSG:32615", {"made by a test"}});
  const CloudData back = read_ply_cloud(folder / "a.ply");
  EXPECT_EQ(back.cloud.positions, cloud.positions);  // a UTM offset costs nothing
  EXPECT_EQ(back.cloud.normals, cloud.normals);
  EXPECT_EQ(back.cloud.colours, cloud.colours);
  EXPECT_EQ(back.cloud.intensity, cloud.intensity);
  EXPECT_EQ(back.cloud.classification, cloud.classification);
  EXPECT_EQ(back.cloud.gps_time, cloud.gps_time);
  ASSERT_EQ(back.cloud.scalars.size(), 3U);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_EQ(back.cloud.scalars[c].name, cloud.scalars[c].name);
    EXPECT_EQ(back.cloud.scalars[c].type, cloud.scalars[c].type);
    EXPECT_EQ(back.cloud.scalars[c].values, cloud.scalars[c].values);
  }
  EXPECT_EQ(back.facts.crs, "EPSG:32615");
  EXPECT_THAT(back.facts.comments, ::testing::ElementsAre("made by a test"));
  EXPECT_TRUE(back.facts.warnings.empty());
}

TEST(Ply, MeshComesBack) {
  const testing::TempFolder folder;
  geometry::TriangleMesh mesh;
  mesh.vertices = {{500000.125, 4000000.25, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 1, 2}, {3, 2, 1}};
  mesh.colours = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {255, 0, 128}};
  write_ply(folder / "a.ply", mesh);
  const MeshData back = read_ply_mesh(folder / "a.ply");
  EXPECT_EQ(back.mesh.vertices, mesh.vertices);
  EXPECT_EQ(back.mesh.triangles, mesh.triangles);
  EXPECT_EQ(back.mesh.colours, mesh.colours);
  EXPECT_EQ(back.facts.declared_faces, 2U);
}

TEST(Ply, AsciiAndBothByteOrdersAgree) {
  const testing::TempFolder folder;
  const std::string properties =
      "element vertex 1\nproperty short x\nproperty float y\nproperty double z\nproperty list uchar int extra\n"
      "element face 1\nproperty list uchar int vertex_index\nend_header\n";
  std::string ascii = "ply\nformat ascii 1.0\n" + properties + "-2 0.5 3\n2 9 9\n3 0 0 0\n";
  std::string little = "ply\nformat binary_little_endian 1.0\n" + properties;
  std::string big = "ply\r\nformat binary_big_endian 1.0\r\ncomment CR LF in the header\r\n" + properties;
  const auto put = [](std::string& file, auto value, bool swap) {
    std::string bytes(reinterpret_cast<const char*>(&value), sizeof(value));
    if (swap) std::reverse(bytes.begin(), bytes.end());
    file += bytes;
  };
  for (std::string* file : {&little, &big}) {
    const bool swap = file == &big;
    put(*file, std::int16_t{-2}, swap);
    put(*file, 0.5F, swap);
    put(*file, 3.0, swap);
    put(*file, std::uint8_t{2}, swap);
    put(*file, 9, swap);
    put(*file, 9, swap);
    put(*file, std::uint8_t{3}, swap);
    for (int i = 0; i < 3; ++i) put(*file, 0, swap);
  }
  for (const std::string& content : {ascii, little, big}) {
    base::write_file(folder / "a.ply", content);
    const MeshData mesh = read_ply_mesh(folder / "a.ply");
    ASSERT_EQ(mesh.mesh.vertices.size(), 1U);
    EXPECT_EQ(mesh.mesh.vertices[0], geometry::Vec3(-2, 0.5, 3));
    ASSERT_EQ(mesh.mesh.triangles.size(), 1U);
    EXPECT_THAT(mesh.facts.warnings, ::testing::ElementsAre(HasSubstr("list 'extra'")));
    EXPECT_EQ(read_ply_cloud(folder / "a.ply").cloud.size(), 1U);
  }
}

TEST(Ply, PolygonsBecomeFans) {
  const testing::TempFolder folder;
  base::write_file(folder / "a.ply",
                   "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
                   "element face 3\nproperty uchar flag\nproperty list uchar uint vertex_indices\nend_header\n"
                   "0 0 0\n1 0 0\n1 1 0\n0 1 0\n-1 0.5 0\n7 5 0 1 2 3 4\n7 2 0 1\n7 3 4 3 0\n");
  const MeshData mesh = read_ply_mesh(folder / "a.ply");
  EXPECT_THAT(mesh.mesh.triangles, ::testing::ElementsAre(geometry::Triangle{0, 1, 2}, geometry::Triangle{0, 2, 3},
                                                          geometry::Triangle{0, 3, 4}, geometry::Triangle{4, 3, 0}));
  EXPECT_EQ(mesh.facts.dropped_faces, 1U);
}

TEST(Ply, DropsVerticesThatAreNotFinite) {
  const testing::TempFolder folder;
  base::write_file(folder / "a.ply",
                   "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                   "element face 2\nproperty list uchar uint vertex_indices\nend_header\n"
                   "0 0 0\nnan 0 0\n1 1 0\n0 1 inf\n3 0 1 2\n3 0 2 0\n");
  EXPECT_EQ(read_ply_cloud(folder / "a.ply").facts.dropped_points, 2U);
  const MeshData mesh = read_ply_mesh(folder / "a.ply");
  EXPECT_EQ(mesh.mesh.vertices.size(), 2U);
  EXPECT_THAT(mesh.mesh.triangles, ::testing::ElementsAre(geometry::Triangle{0, 1, 0}));
}

TEST(Ply, Samples) {
  const CloudData issue = read_ply_cloud(pdal("issue_2421.ply"));
  EXPECT_EQ(issue.cloud.positions[0], geometry::Vec3(1.23457, 12345.67890, 1234567890.12345));
  EXPECT_EQ(issue.cloud.scalars[0].values[0], 1234567890.0);
  EXPECT_EQ(read_ply_mesh(pdal("mesh.ply")).mesh.triangles.size(), 2U);
  EXPECT_EQ(read_ply_cloud(pdal("simple_binary.ply")).cloud.positions,
            read_ply_cloud(pdal("simple_text.ply")).cloud.positions);
  const CloudData extra = read_ply_cloud(pdal("text_extradim.ply"));
  EXPECT_EQ(extra.cloud.scalar("omg")->values[0], 1234.0);
  EXPECT_EQ(extra.cloud.colours.size(), 1U);
  EXPECT_EQ(extra.cloud.normals.size(), 1U);
}

void expect_refused(const std::string& content, const std::string& record, const std::string& message) {
  const testing::TempFolder folder;
  base::write_file(folder / "a.ply", content);
  try {
    (void)read_ply_mesh(folder / "a.ply");
    FAIL() << "accepted: " << content;
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::invalid_input);
    EXPECT_EQ(error.record(), record) << error.what();
    EXPECT_THAT(error.what(), HasSubstr(message));
  }
}

TEST(Ply, BadInputIsNamedByLineOrByte) {
  const std::string head = "ply\nformat ascii 1.0\n";
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const std::string face = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  expect_refused("plyx\n", "byte 0", "not a PLY file");
  expect_refused(head, "line 2", "does not end");
  expect_refused(head + "element vertex -1\n", "line 3", "count");
  expect_refused(head + "element vertex 1\nproperty quad x\n", "line 4", "unknown property type");
  expect_refused(head + "element vertex 9000000000000000000\n" + xyz + "end_header\n1 2 3\n", "line 7",
                 "more 'vertex' records");
  expect_refused(head + "element vertex 1\n" + xyz + "end_header\n1 2 x\n", "line 8", "not a number");
  expect_refused(head + "element vertex 1\n" + xyz + face + "1 2 3\n3 0 0 1\n", "line 11", "does not exist");
  expect_refused(head + "element vertex 1\n" + xyz + face + "1 2 3\n300 0 0 0\n", "line 11", "longer than the rest");
  expect_refused(head + "element vertex 0\nproperty float x\nend_header\n", "line 5", "lack a coordinate");
  expect_refused(
      "ply\nformat binary_little_endian 1.0\nelement vertex 2\n" + xyz + "end_header\n" + std::string(23, 'a'),
      "byte 115", "more 'vertex' records");
  expect_refused("ply\nformat ascii 1.0\nend_header\n", "line 3", "no vertices");
}

TEST(Ply, NoPointsGiveAnEmptyCloud) {
  const testing::TempFolder folder;
  write_ply(folder / "a.ply", PointCloud{});
  EXPECT_TRUE(read_ply_cloud(folder / "a.ply").cloud.empty());
}

TEST(Ply, WritersRefuseWhatIsNotFinite) {
  const testing::TempFolder folder;
  PointCloud cloud;
  cloud.positions = {{0, INFINITY, 0}};
  EXPECT_THROW(write_ply(folder / "a.ply", cloud), base::Error);
}

}  // namespace
}  // namespace cairn::io
