#include "io/mesh.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "geometry/mass_properties.hpp"
#include "io/assimp_mesh.hpp"
#include "io/glb.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using geometry::Vec3;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// A float of coordinates below 4 m holds steps of 2.4e-7 m.
constexpr double kFloat = 3e-7;

// A tetrahedron taller than wide, coloured.
geometry::TriangleMesh tetrahedron() {
  geometry::TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  mesh.colours = {{255, 0, 0}, {0, 128, 0}, {1, 2, 64}, {255, 255, 255}};
  return mesh;
}

TEST(Glb, AssimpReadsItBackInItsPlace) {
  const testing::TempFolder folder;
  geometry::TriangleMesh mesh = tetrahedron();
  GlbWriteOptions options;
  options.origin = {576661.97, 5188114.06, 156.06};
  for (auto& p : mesh.vertices) p += options.origin;
  options.properties = Json::object({{"target_id", 7}});
  write_glb(folder / "a.glb", mesh, options);
  const MeshData back = read_mesh(folder / "a.glb");
  ASSERT_EQ(back.mesh.vertices.size(), mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    EXPECT_LT((back.mesh.vertices[i] - mesh.vertices[i]).norm(), kFloat);
  EXPECT_EQ(back.mesh.triangles, mesh.triangles);
  EXPECT_EQ(back.mesh.colours, mesh.colours);
  EXPECT_NEAR(geometry::mass_properties(back.mesh).volume, 1.0, 1e-6);
  EXPECT_TRUE(back.facts.warnings.empty()) << back.facts.warnings.front();
}

template <typename T>
T at(const std::string& file, std::size_t offset) {
  T value;
  std::memcpy(&value, file.data() + offset, sizeof(T));
  return value;
}

// The rules of glTF 2.0 that loaders trip over, checked on the bytes.
TEST(Glb, IsValidGltf) {
  const testing::TempFolder folder;
  write_glb(folder / "a.glb", tetrahedron());
  const std::string file = base::read_file(folder / "a.glb");
  ASSERT_EQ(file.substr(0, 4), "glTF");
  EXPECT_EQ(at<std::uint32_t>(file, 8), file.size());
  const std::size_t json_length = at<std::uint32_t>(file, 12);
  EXPECT_EQ(json_length % 4, 0U);
  EXPECT_EQ(file.substr(16, 4), "JSON");
  const std::size_t body = 20 + json_length + 8;
  const std::size_t length = at<std::uint32_t>(file, 20 + json_length);
  EXPECT_EQ(length % 4, 0U);
  EXPECT_EQ(body + length, file.size());
  const Json document = read_glb_json(folder / "a.glb");
  EXPECT_EQ(document.at("asset").at("version").as_string(), "2.0");
  EXPECT_EQ(document.at("buffers").as_array()[0].at("byteLength").as_integer(), static_cast<std::int64_t>(length));
  EXPECT_TRUE(document.at("materials").as_array()[0].at("doubleSided").as_bool());
  const auto& views = document.at("bufferViews").as_array();
  const auto& accessors = document.at("accessors").as_array();
  ASSERT_EQ(views.size(), 4U);
  ASSERT_EQ(accessors.size(), 4U);
  std::int64_t end = 0;
  for (const auto& view : views) {
    EXPECT_EQ(view.at("byteOffset").as_integer(), end);
    EXPECT_EQ(end % 4, 0);
    end += view.at("byteLength").as_integer();
  }
  EXPECT_EQ(end, static_cast<std::int64_t>(length));
  EXPECT_EQ(views[0].at("target").as_integer(), 34962);
  EXPECT_EQ(views[3].at("target").as_integer(), 34963);
  // y-up: height 3 along y, north 2 along -z.
  EXPECT_EQ(accessors[0].at("min").as_vec3(), Vec3(0, 0, -2));
  EXPECT_EQ(accessors[0].at("max").as_vec3(), Vec3(1, 3, 0));
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t normal = body + 12 * 4 + 12 * i;
    const Vec3 n(at<float>(file, normal), at<float>(file, normal + 4), at<float>(file, normal + 8));
    EXPECT_NEAR(n.norm(), 1.0, 1e-6);  // float
  }
  EXPECT_EQ(document.at("scenes").as_array()[0].at("extras").at("origin_m").as_vec3(), Vec3(0, 0, 0));
}

TEST(Glb, RefusesEmptyAndNotFinite) {
  const testing::TempFolder folder;
  EXPECT_THROW(write_glb(folder / "a.glb", {}), base::Error);
  geometry::TriangleMesh mesh = tetrahedron();
  mesh.vertices[0].x() = NAN;
  EXPECT_THROW(write_glb(folder / "a.glb", mesh), base::Error);
}

TEST(Mesh, ReadsStlOffAndCollada) {
  const testing::TempFolder folder;
  const geometry::TriangleMesh mesh = tetrahedron();
  std::string stl(80, ' ');
  const auto put = [&](auto value) { stl.append(reinterpret_cast<const char*>(&value), sizeof(value)); };
  put(std::uint32_t{4});
  for (std::size_t t = 0; t < 4; ++t) {
    for (int k = 0; k < 3; ++k) put(0.0F);
    for (const auto v : mesh.triangles[t])
      for (int k = 0; k < 3; ++k) put(static_cast<float>(mesh.vertices[v][k]));
    put(std::uint16_t{0});
  }
  base::write_file(folder / "a.stl", stl);
  const MeshData solid = read_mesh(folder / "a.stl");
  EXPECT_EQ(solid.mesh.vertices.size(), 4U);  // corners joined
  EXPECT_NEAR(geometry::mass_properties(solid.mesh).volume, 1.0, 1e-6);
  EXPECT_EQ(solid.mesh.bounds().max, Vec3(1, 2, 3));

  base::write_file(folder / "a.off", "OFF\n4 4 6\n0 0 0\n1 0 0\n0 2 0\n0 0 3\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n");
  EXPECT_NEAR(geometry::mass_properties(read_mesh(folder / "a.off").mesh).volume, 1.0, 1e-6);

  for (const std::string axis : {"Y_UP", "Z_UP"}) {
    base::write_file(
        folder / "a.dae",
        "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\">"
        "<asset><unit name=\"meter\" meter=\"1\"/><up_axis>" +
            axis +
            "</up_axis></asset>"
            "<library_geometries><geometry id=\"g\"><mesh><source id=\"p\"><float_array id=\"a\" count=\"9\">"
            "0 0 0 1 0 0 0 2 5</float_array><technique_common><accessor source=\"#a\" count=\"3\" stride=\"3\">"
            "<param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/><param name=\"Z\" type=\"float\"/>"
            "</accessor></technique_common></source><vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/>"
            "</vertices><triangles count=\"1\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>0 1 2</p>"
            "</triangles></mesh></geometry></library_geometries><library_visual_scenes><visual_scene id=\"s\">"
            "<node id=\"n\"><instance_geometry url=\"#g\"/></node></visual_scene></library_visual_scenes>"
            "<scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>");
    const MeshData dae = read_mesh(folder / "a.dae");
    ASSERT_EQ(dae.mesh.triangles.size(), 1U);
    const Vec3 third = dae.mesh.vertices[dae.mesh.triangles[0][2]];
    EXPECT_LT((third - (axis == "Z_UP" ? Vec3(0, 2, 5) : Vec3(0, -5, 2))).norm(), 1e-6) << axis << third.transpose();
  }
}

TEST(Mesh, NeverOpensReferencedFiles) {
  const testing::TempFolder folder;
  base::write_file(folder / "b.bin", std::string(36, '\0'));
  base::write_file(folder / "a.gltf",
                   R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
                   R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)"
                   R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],)"
                   R"("bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"uri":"b.bin","byteLength":36}]})");
  try {
    (void)read_mesh(folder / "a.gltf");
    FAIL() << "followed a reference";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::invalid_input);
    EXPECT_THAT(error.what(), HasSubstr("b.bin"));
  }
}

TEST(Mesh, WarnsWhenSinglePrecisionRoundsCoordinates) {
  const testing::TempFolder folder;
  base::write_file(folder / "a.off", "OFF\n3 1 3\n500000 5000000 0\n500001 5000000 0\n500000 5000001 0\n3 0 1 2\n");
  EXPECT_THAT(read_mesh(folder / "a.off").facts.warnings, ElementsAre(HasSubstr("single-precision")));
}

TEST(Mesh, RecognisesByContentBeforeExtension) {
  const testing::TempFolder folder;
  write_mesh(folder / "a.ply", tetrahedron());
  std::filesystem::rename(folder / "a.ply", folder / "a.obj");
  EXPECT_EQ(recognise_mesh(folder / "a.obj"), MeshFormat::ply);
  EXPECT_EQ(read_mesh(folder / "a.obj").mesh.triangles.size(), 4U);
  base::write_file(folder / "a.bin", "????");
  EXPECT_THROW((void)recognise_mesh(folder / "a.bin"), base::Error);
  EXPECT_THROW(write_mesh(folder / "a.stl", tetrahedron()), base::Error);
}

}  // namespace
}  // namespace cairn::io
