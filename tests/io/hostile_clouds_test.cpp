// Damaged files of every format: each either reads, or throws base::Error that names the file and a place.
// Run under the sanitizers too.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "io/cloud.hpp"
#include "io/las.hpp"
#include "io/mesh.hpp"
#include "io/obj.hpp"
#include "io/pcd.hpp"
#include "io/ply.hpp"
#include "io/xyz.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

geometry::PointCloud sample_cloud() {
  geometry::PointCloud cloud;
  for (int i = 0; i < 6; ++i) {
    cloud.positions.emplace_back(500000.0 + i, 4000000.0 - i, 0.5 * i);
    cloud.colours.push_back({257, 0, 65535});
    cloud.normals.emplace_back(0, 0, 1);
    cloud.intensity.push_back(static_cast<std::uint16_t>(i));
  }
  cloud.add_scalar("id", geometry::ScalarType::u32, "").values[0] = 7;
  return cloud;
}

geometry::TriangleMesh sample_mesh() {
  geometry::TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  return mesh;
}

struct Target {
  const char* name;  // of the file; chooses the reader through the front doors
  bool mesh;
  std::string (*content)();
};

template <typename Write>
std::string written(const char* name, const Write& write) {
  const testing::TempFolder folder;
  write(folder / name);
  return base::read_file(folder / name);
}

std::string las14() {
  return written("a.las", [](const auto& path) {
    LasMetadata source;
    source.records.push_back({"user", 7, "kept", std::vector<std::byte>(9), true});
    LasWriteOptions options;
    options.crs_wkt = "GEOGCS[\"x\"]";
    options.crs = "EPSG:4326";
    options.source = &source;
    write_las(path, sample_cloud(), options);
  });
}
std::string las12() {
  return written("a.las", [](const auto& path) {
    LasWriteOptions options;
    options.minor_version = 2;
    options.crs = "EPSG:32615";
    write_las(path, sample_cloud(), options);
  });
}
std::string ply_cloud() {
  return written("a.ply", [](const auto& path) { write_ply(path, sample_cloud()); });
}
std::string ply_mesh() {
  return written("a.ply", [](const auto& path) { write_ply(path, sample_mesh()); });
}
std::string ply_ascii() {
  return "ply\nformat ascii 1.0\ncomment c\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
         "property list uchar int l\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
         "0 0 0 1 5\n1 0 0 0\n0 1 0 2 1 1\n3 0 1 2\n";
}
std::string pcd_binary() {
  return written("a.pcd", [](const auto& path) { write_pcd(path, sample_cloud()); });
}
std::string pcd_ascii() {
  return "VERSION .7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA "
         "ascii\n1 2 3 4\n5 6 7 8\n";
}
std::string pcd_compressed() {
  std::string file =
      "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 4\nHEIGHT 1\nPOINTS 4\nDATA "
      "binary_compressed\n";
  // 48 zero bytes: one literal, then copies.
  const std::string packed("\x00\x00\xe0\x26\x00", 5);
  const std::uint32_t sizes[2] = {5, 48};
  file.append(reinterpret_cast<const char*>(sizes), 8);
  return file + packed;
}
std::string obj() {
  return "# c\nmtllib x.mtl\nv 0 0 0\nv 1 0 0 1\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2//1 \\\n-1\n";
}
std::string xyz() {
  return "x,y,z,red,green,blue\n1,2,3,4,5,6\n7,8,9,1,2,3\n";
}
std::string glb() {
  return written("a.glb", [](const auto& path) { write_glb(path, sample_mesh()); });
}

class Damaged : public ::testing::TestWithParam<Target> {
 protected:
  // True where it was read, false where it was refused; anything else fails the test.
  bool try_read(const std::string& content) {
    const auto path = folder_ / GetParam().name;
    // Rewriting a file in place makes ext4 flush it; a new one stays in memory.
    std::filesystem::remove(path);
    base::write_file(path, content);
    try {
      if (GetParam().mesh) check(read_mesh(path));
      else check(read_cloud(path));
      return true;
    } catch (const base::Error& error) {
      EXPECT_EQ(error.code(), base::ErrorCode::invalid_input) << error.what();
      EXPECT_EQ(error.file(), path.string()) << error.what();
      return false;
    }
  }

 private:
  // What is read is whole: columns of equal length, finite, indices in range.
  static void check(const CloudFile& data) {
    EXPECT_TRUE(data.cloud.consistent());
    for (const auto& p : data.cloud.positions) EXPECT_TRUE(p.allFinite());
    for (const auto& n : data.cloud.normals) EXPECT_TRUE(n.allFinite());
    for (const auto& column : data.cloud.scalars)
      for (const double v : column.values) EXPECT_TRUE(std::isfinite(v));
  }
  static void check(const MeshData& data) {
    for (const auto& p : data.mesh.vertices) EXPECT_TRUE(p.allFinite());
    for (const auto& t : data.mesh.triangles)
      for (const auto v : t) EXPECT_LT(v, data.mesh.vertices.size());
  }

  testing::TempFolder folder_;
};

TEST_P(Damaged, ReadsWhole) {
  EXPECT_TRUE(try_read(GetParam().content()));
}

TEST_P(Damaged, EveryPrefixIsReadOrRefused) {
  const std::string whole = GetParam().content();
  std::size_t refused = 0;
  for (std::size_t length = 0; length < whole.size(); ++length)
    if (!try_read(whole.substr(0, length))) ++refused;
  // Text may lose its last line end and still be whole; most prefixes cannot.
  EXPECT_GT(refused, whole.size() / 4);
}

TEST_P(Damaged, EveryByteChangedIsReadOrRefused) {
  const std::string whole = GetParam().content();
  std::size_t refused = 0;
  for (std::size_t i = 0; i < std::min<std::size_t>(whole.size(), 1200); ++i)
    for (const int value : {0x00, 0x7f, 0xff}) {
      std::string changed = whole;
      changed[i] = static_cast<char>(value);
      if (!try_read(changed)) ++refused;
    }
  EXPECT_GT(refused, 0U);
}

INSTANTIATE_TEST_SUITE_P(
    Formats, Damaged,
    ::testing::Values(Target{"las14.las", false, las14}, Target{"las12.las", false, las12},
                      Target{"cloud.ply", false, ply_cloud}, Target{"mesh.ply", true, ply_mesh},
                      Target{"ascii.ply", true, ply_ascii}, Target{"ascii_cloud.ply", false, ply_ascii},
                      Target{"binary.pcd", false, pcd_binary}, Target{"ascii.pcd", false, pcd_ascii},
                      Target{"compressed.pcd", false, pcd_compressed}, Target{"mesh.obj", true, obj},
                      Target{"cloud.obj", false, obj}, Target{"points.csv", false, xyz}, Target{"mesh.glb", true, glb}),
    [](const auto& tested) {
      std::string name = tested.param.name;
      for (char& c : name)
        if (c == '.') c = '_';
      return name;
    });

// Counts that no file of this size can justify are refused before memory is reserved: the message names the count.
TEST(HugeCounts, AreRefused) {
  const testing::TempFolder folder;
  const auto refused = [&](const char* name, const std::string& content, const std::string& found) {
    base::write_file(folder / name, content);
    try {
      (void)read_cloud(folder / name);
      FAIL() << name << " was read";
    } catch (const base::Error& error) {
      EXPECT_EQ(error.code(), base::ErrorCode::invalid_input);
      EXPECT_NE(std::string(error.what()).find(found), std::string::npos) << error.what();
    }
  };
  const auto patched = [](std::string file, std::size_t offset, std::uint64_t value, std::size_t bytes) {
    std::memcpy(file.data() + offset, &value, bytes);
    return file;
  };
  refused("a.las", patched(las14(), 247, 1ULL << 62U, 8), "4611686018427387904");
  refused("a.las", patched(las12(), 107, 0xFFFFFFFFU, 4), "4294967295");
  refused("a.las", patched(las14(), 100, 0xFFFFFFFFU, 4), "variable length records");
  refused("a.las", patched(las14(), 243, 0xFFFFFFFFU, 4), "extended variable length records");
  refused("a.ply",
          "ply\nformat binary_little_endian 1.0\nelement vertex 4611686018427387904\nproperty float x\n"
          "property float y\nproperty float z\nend_header\n",
          "4611686018427387904");
  refused("a.pcd", "FIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nWIDTH 4611686018427387904\nDATA binary\n",
          "4611686018427387904");
}

}  // namespace
}  // namespace cairn::io
