#include "io/colmap.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "camera/projection.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// COLMAP's binary layout, written independently of the reader.
class Binary {
 public:
  Binary& u8(std::uint8_t v) { return put(v, 1); }
  Binary& u32(std::uint32_t v) { return put(v, 4); }
  Binary& u64(std::uint64_t v) { return put(v, 8); }
  Binary& f64(double v) { return put(std::bit_cast<std::uint64_t>(v), 8); }
  Binary& text(std::string_view v) {
    bytes += v;
    bytes += '\0';
    return *this;
  }
  std::string bytes;

 private:
  Binary& put(std::uint64_t v, int n) {
    for (int i = 0; i < n; ++i) bytes += static_cast<char>(v >> (8 * i) & 0xFF);
    return *this;
  }
};

constexpr std::uint64_t kNoPoint = ~std::uint64_t{0};

struct Model {
  std::string cameras, images, points;
};

// Two cameras, three images (ids neither sorted nor contiguous, one without key points), two points.
Model small_text() {
  return {"# comment\n7 OPENCV 400 300 200 210 201 151 0.1 0.2 0.3 0.4\n2 SIMPLE_PINHOLE 40 30 20 20 15\n",
          "# Image list\n"
          "30 0 1 0 0 1 2 3 7 a b.jpg\n10.5 20.5 100 1 2 -1 30.5 40.5 200\n"
          "4 1 0 0 0 0 0 0 2 sub/c.jpg\n\n"
          "5 0.5 0.5 0.5 0.5 -1 0 9 7 d.jpg\n11 21 100 31 41 200",
          "200 1 2 3 255 0 10 0.5 30 2 5 1\n100 4 5 6 1 2 3 -1 30 0 5 0\n"};
}

Model small_binary() {
  Binary cameras, images, points;
  cameras.u64(2);
  cameras.u32(7).u32(4).u64(400).u64(300);
  for (const double v : {200.0, 210.0, 201.0, 151.0, 0.1, 0.2, 0.3, 0.4}) cameras.f64(v);
  cameras.u32(2).u32(0).u64(40).u64(30).f64(20).f64(20).f64(15);
  images.u64(3);
  images.u32(30);
  for (const double v : {0.0, 1.0, 0.0, 0.0, 1.0, 2.0, 3.0}) images.f64(v);
  images.u32(7).text("a b.jpg").u64(3);
  images.f64(10.5).f64(20.5).u64(100).f64(1).f64(2).u64(kNoPoint).f64(30.5).f64(40.5).u64(200);
  images.u32(4);
  for (const double v : {1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}) images.f64(v);
  images.u32(2).text("sub/c.jpg").u64(0);
  images.u32(5);
  for (const double v : {0.5, 0.5, 0.5, 0.5, -1.0, 0.0, 9.0}) images.f64(v);
  images.u32(7).text("d.jpg").u64(2).f64(11).f64(21).u64(100).f64(31).f64(41).u64(200);
  points.u64(2);
  points.u64(200).f64(1).f64(2).f64(3).u8(255).u8(0).u8(10).f64(0.5).u64(2).u32(30).u32(2).u32(5).u32(1);
  points.u64(100).f64(4).f64(5).f64(6).u8(1).u8(2).u8(3).f64(-1).u64(2).u32(30).u32(0).u32(5).u32(0);
  return {cameras.bytes, images.bytes, points.bytes};
}

ColmapModel text_of(const Model& m) {
  return parse_colmap_text({m.cameras, m.images, m.points, "m"});
}
ColmapModel binary_of(const Model& m) {
  return parse_colmap_binary({m.cameras, m.images, m.points, "m"});
}

void expect_small(const ColmapModel& m) {
  ASSERT_EQ(m.cameras.size(), 2U);
  EXPECT_EQ(m.cameras[0].id.value, 2);
  EXPECT_EQ(m.cameras[0].model, survey::CameraModel::pinhole);
  EXPECT_EQ(m.cameras[0].fy_px, 20.0);
  const survey::Camera& c = m.cameras[1];
  EXPECT_EQ(c.model, survey::CameraModel::brown);
  EXPECT_EQ(c.width_px, 400);
  EXPECT_EQ(c.height_px, 300);
  EXPECT_EQ((std::vector<double>{c.fx_px, c.fy_px, c.cx_px, c.cy_px, c.k1, c.k2, c.p1, c.p2}),
            (std::vector<double>{200, 210, 201, 151, 0.1, 0.2, 0.3, 0.4}));
  ASSERT_EQ(m.images.size(), 3U);
  EXPECT_EQ(m.images[0].id, 4);
  EXPECT_THAT(m.images[0].observations, IsEmpty());
  EXPECT_EQ(m.images[0].name, "sub/c.jpg");
  EXPECT_EQ(m.images[2].name, "a b.jpg") << "names may hold blanks";
  // X_cam = R X + t with R a half turn about x: C = -R^T t = (-1, 2, 3).
  EXPECT_EQ(m.images[2].T_world_camera.translation, geometry::Vec3(-1, 2, 3));
  ASSERT_EQ(m.images[2].observations.size(), 2U);
  EXPECT_EQ(m.images[2].observations[1].index, 2);
  EXPECT_EQ(m.images[2].observations[1].point, 200);
  EXPECT_EQ(m.images[2].observations[1].pixel, geometry::Vec2(30.5, 40.5));
  ASSERT_EQ(m.points.size(), 2U);
  EXPECT_EQ(m.points[1].id, 200);
  EXPECT_EQ(m.points[1].position, geometry::Vec3(1, 2, 3));
  EXPECT_THAT(m.points[1].rgb, ElementsAre(255, 0, 10));
  EXPECT_EQ(m.points[0].error_px, -1.0);
}

TEST(Colmap, ReadsText) {
  expect_small(text_of(small_text()));
}

TEST(Colmap, ReadsBinary) {
  expect_small(binary_of(small_binary()));
}

TEST(Colmap, TakesCrLf) {
  Model m = small_text();
  for (std::string* text : {&m.cameras, &m.images, &m.points}) {
    std::string out;
    for (const char c : *text) out += c == '\n' ? std::string("\r\n") : std::string(1, c);
    *text = out;
  }
  expect_small(text_of(m));
}

TEST(Colmap, EveryCameraModelPutsItsParametersWhereTheyBelong) {
  const auto camera = [](const std::string& line) { return parse_colmap_text({line, "", "", "m"}).cameras.at(0); };
  const auto radial = camera("1 RADIAL 4000 2250 2285.7 2000 1125 0.004 0.015");
  EXPECT_EQ(radial.model, survey::CameraModel::radial);
  EXPECT_EQ(radial.fx_px, radial.fy_px);
  EXPECT_EQ(radial.k1, 0.004);
  EXPECT_EQ(radial.k2, 0.015);
  const auto simple = camera("1 SIMPLE_RADIAL 40 30 20 21 15 0.3");
  EXPECT_EQ(simple.model, survey::CameraModel::radial);
  EXPECT_EQ(simple.cx_px, 21.0);
  EXPECT_EQ(simple.k1, 0.3);
  const auto pinhole = camera("1 PINHOLE 40 30 20 22 21 15");
  EXPECT_EQ(pinhole.fy_px, 22.0);
  EXPECT_EQ(pinhole.cy_px, 15.0);
  const auto fisheye = camera("1 OPENCV_FISHEYE 40 30 20 22 21 15 1 2 3 4");
  EXPECT_EQ(fisheye.model, survey::CameraModel::fisheye);
  EXPECT_EQ(fisheye.k4, 4.0);
  EXPECT_EQ(fisheye.p1, 0.0);
}

// The real model: points must fall on their key points, which an un-inverted pose or another
// quaternion order would break by hundreds of pixels.
TEST(Colmap, BrightonBeachReprojects) {
  const ColmapModel m = read_colmap(testing::sample("brighton_beach/colmap_enu"));
  EXPECT_FALSE(m.binary);
  EXPECT_THAT(m.notes, IsEmpty());
  ASSERT_EQ(m.cameras.size(), 1U);
  EXPECT_EQ(m.images.size(), 18U);
  EXPECT_EQ(m.points.size(), 4881U);
  std::size_t observations = 0;
  std::vector<double> error(m.points.size(), 0.0);
  std::vector<int> count(m.points.size(), 0);
  for (const auto& image : m.images) {
    EXPECT_GT(image.T_world_camera.translation.z(), 35.0) << "ENU: cameras some 40 m above the origin";
    EXPECT_LT(image.T_world_camera.translation.z(), 45.0);
    EXPECT_LT((image.T_world_camera.rotation * geometry::Vec3::UnitZ()).z(), -0.99) << "nadir views";
    for (const auto& seen : image.observations) {
      const auto it = std::lower_bound(m.points.begin(), m.points.end(), seen.point,
                                       [](const ColmapPoint& p, std::int64_t id) { return p.id < id; });
      const auto pixel = camera::project_world(m.cameras[0], image.T_world_camera, it->position);
      ASSERT_TRUE(pixel);
      const auto index = static_cast<std::size_t>(it - m.points.begin());
      error[index] += (*pixel - seen.pixel).norm();
      ++count[index];
      ++observations;
    }
  }
  EXPECT_EQ(observations, 19804U);
  double sum = 0.0;
  for (std::size_t i = 0; i < error.size(); ++i) sum += error[i] / count[i];
  // The README of the data states 0.806 px: COLMAP's mean over the points of each point's mean.
  constexpr double kStatedError = 0.806, kTolerance = 5e-4;  // px; the figure has three digits
  EXPECT_NEAR(sum / static_cast<double>(error.size()), kStatedError, kTolerance);
}

TEST(Colmap, BinaryIsPreferredAndUnreadFilesAreNoted) {
  const testing::TempFolder folder;
  const Model text = small_text(), binary = small_binary();
  base::write_file(folder / "cameras.txt", text.cameras);
  base::write_file(folder / "images.txt", text.images);
  EXPECT_THAT(read_colmap(folder.path()).notes, ElementsAre(HasSubstr("4 key points"), HasSubstr("no points3D")));
  base::write_file(folder / "points3D.txt", text.points);
  expect_small(read_colmap(folder.path()));
  base::write_file(folder / "cameras.bin", binary.cameras);
  EXPECT_FALSE(read_colmap(folder.path()).binary) << "half a binary model is none";
  base::write_file(folder / "images.bin", binary.images);
  base::write_file(folder / "points3D.bin", binary.points);
  base::write_file(folder / "rigs.bin", "");
  const ColmapModel m = read_colmap(folder.path());
  EXPECT_TRUE(m.binary);
  expect_small(m);
  EXPECT_THAT(m.notes, ElementsAre(HasSubstr("binary one was read"), HasSubstr("rigs and frames")));
}

TEST(Colmap, FolderWithoutModelIsNotFound) {
  const testing::TempFolder folder;
  try {
    (void)read_colmap(folder.path());
    FAIL();
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::not_found);
    EXPECT_THAT(error.hint(), HasSubstr("sparse/0"));
  }
}

// Every proper prefix of every file must be refused with the offset, without reserving what a header claims.
TEST(Colmap, BinaryCutAnywhereIsRefused) {
  const Model whole = small_binary();
  for (std::string Model::*file : {&Model::cameras, &Model::images, &Model::points}) {
    for (std::size_t length = 0; length < (whole.*file).size(); ++length) {
      Model cut = whole;
      (cut.*file).resize(length);
      try {
        (void)binary_of(cut);
        FAIL() << "accepted " << length << " of " << (whole.*file).size() << " bytes";
      } catch (const base::Error& error) {
        EXPECT_EQ(error.code(), base::ErrorCode::invalid_input);
        EXPECT_THAT(error.record(), HasSubstr("byte ")) << error.what();
      }
    }
    Model longer = whole;
    longer.*file += '\0';
    EXPECT_THROW((void)binary_of(longer), base::Error) << "bytes after the end";
  }
}

TEST(Colmap, CountsBeyondTheFileAreRefused) {
  Model m = small_binary();
  for (std::string Model::*file : {&Model::cameras, &Model::images, &Model::points}) {
    Model bad = m;
    for (std::size_t i = 0; i < 8; ++i) (bad.*file)[i] = static_cast<char>(i < 7 ? 0xFF : 0x7F);
    try {
      (void)binary_of(bad);
      FAIL();
    } catch (const base::Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("more than the file can hold"));
      EXPECT_EQ(error.record(), "byte 8");
    }
  }
}

struct Fault {
  std::string name;
  std::string Model::*file;
  std::string find, replace, message;
};

class ColmapFault : public ::testing::TestWithParam<Fault> {};

TEST_P(ColmapFault, IsRefusedWithFileAndLine) {
  const Fault& fault = GetParam();
  Model m = small_text();
  std::string& text = m.*(fault.file);
  const auto at = text.find(fault.find);
  ASSERT_NE(at, std::string::npos) << "the fault does not apply";
  text.replace(at, fault.find.size(), fault.replace);
  try {
    (void)text_of(m);
    FAIL() << "accepted";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::invalid_input);
    EXPECT_THAT(error.what(), HasSubstr(fault.message));
    EXPECT_THAT(error.file(), HasSubstr(".txt"));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Faults, ColmapFault,
    ::testing::Values(Fault{"unsupported_model", &Model::cameras, "OPENCV", "FULL_OPENCV", "found FULL_OPENCV"},
                      Fault{"unknown_model", &Model::cameras, "OPENCV", "MAGIC", "'MAGIC'"},
                      Fault{"few_parameters", &Model::cameras, " 0.4\n", "\n", "line 2: camera with the wrong number"},
                      Fault{"many_parameters", &Model::cameras, " 0.4\n", " 0.4 0.5\n", "wrong number of parameters"},
                      Fault{"zero_width", &Model::cameras, "400 300", "0 300", "image size out of range"},
                      Fault{"negative_focal", &Model::cameras, " 200 ", " -200 ", "focal length is not positive"},
                      Fault{"camera_twice", &Model::cameras, "\n2 ", "\n7 ", "camera id appears twice"},
                      Fault{"camera_text", &Model::cameras, "\n2 ", "\ntwo ", "'two'"},
                      Fault{"quaternion_zero", &Model::images, "0 1 0 0 1", "0 0 0 0 1", "|q| = 0"},
                      Fault{"quaternion_long", &Model::images, "0 1 0 0 1", "0 1 1 0 1", "unit length"},
                      Fault{"pose_nan", &Model::images, " 1 2 3 7", " nan 2 3 7", "pose is not finite"},
                      Fault{"pose_inf", &Model::images, " 1 2 3 7", " 1e999 2 3 7", "is not a number"},
                      Fault{"image_camera", &Model::images, " 7 d.jpg", " 8 d.jpg", "unknown camera"},
                      Fault{"image_twice", &Model::images, "\n5 ", "\n4 ", "image id appears twice"},
                      Fault{"name_twice", &Model::images, "d.jpg", "a b.jpg", "two images of one name"},
                      Fault{"no_name", &Model::images, "d.jpg", "", "image without a name"},
                      Fault{"key_point", &Model::images, "11 21 100", "11 x 100", "'x'"},
                      Fault{"key_point_cut", &Model::images, "31 41 200", "31 41", "line ends before"},
                      Fault{"missing_key_point_line", &Model::images, "\n\n5 ", "\n5 ", "line"},
                      Fault{"track_image", &Model::points, "30 2 5 1", "31 2 5 1", "not in the model"},
                      Fault{"track_key_point", &Model::points, "30 2 5 1", "30 0 5 1", "does not name the point"},
                      Fault{"track_cut", &Model::points, "30 2 5 1", "30 2 5", "line ends before"},
                      Fault{"colour", &Model::points, "255 0", "256 0", "colour out of range"},
                      Fault{"point_twice", &Model::points, "100 4", "200 4", "point id appears twice"}),
    [](const auto& fault) { return fault.param.name; });

TEST(Colmap, ObservationsOfMissingPointsAreDroppedWithANote) {
  Model m = small_text();
  m.points = "200 1 2 3 255 0 10 0.5 30 2 5 1\n";
  const ColmapModel model = text_of(m);
  EXPECT_EQ(model.images[2].observations.size(), 1U);
  EXPECT_THAT(model.notes, ElementsAre(HasSubstr("2 key points")));
}

}  // namespace
}  // namespace cairn::io
