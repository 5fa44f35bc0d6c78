#include "io/control_points.hpp"

#include <gmock/gmock.h>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "geodesy/local_frame.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using geometry::Vec2;
using geometry::Vec3;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

survey::Survey survey_with(std::initializer_list<const char*> images, double latitude = 46.8426,
                           double longitude = -91.9940) {
  survey::Survey survey;
  survey.manifest.origin = {{latitude, longitude, 158.0}, survey::HeightType::ellipsoidal, {}};
  survey::Camera camera;
  camera.id = survey::CameraId(1);
  camera.width_px = 3264;
  camera.height_px = 2448;
  camera.fx_px = camera.fy_px = 2800.0;
  survey.manifest.cameras.push_back(camera);
  std::int64_t id = 0;
  for (const auto* image : images) {
    survey::Frame frame;
    frame.id = survey::FrameId(++id);
    frame.camera = camera.id;
    frame.image = std::string("photos/") + image;
    survey.frames.push_back(frame);
  }
  return survey;
}

class ControlPointFiles : public ::testing::Test {
 protected:
  std::filesystem::path file(const std::string& name, const std::string& text) {
    const auto path = folder_ / name;
    base::write_file(path, text);
    return path;
  }
  testing::TempFolder folder_;
};

TEST_F(ControlPointFiles, GcpListInWgs84) {
  const auto survey = survey_with({"a.jpg", "b.jpg"});
  const auto geographic = read_control_points(
      file("gcp.txt",
           "WGS84\n-91.9935 46.8430 170.5 100 200 a.jpg north\n-91.9935 46.8430 170.5 300.5 400 b.jpg north\n"),
      survey);
  ASSERT_THAT(geographic.points, SizeIs(1));
  const auto& point = geographic.points.front();
  EXPECT_EQ(point.name, "north");
  const Vec3 expected = geodesy::LocalFrame(survey.manifest.origin.position).to_local({46.8430, -91.9935, 170.5});
  EXPECT_LT((point.p_world - expected).norm(), 1e-6);
  ASSERT_THAT(point.observations, SizeIs(2));
  EXPECT_EQ(point.observations[0].pixel, Vec2(100.5, 200.5));  // half a pixel: counted from the first pixel's centre
  EXPECT_EQ(point.observations[1].frame, survey::FrameId(2));
  EXPECT_THAT(geographic.convention, HasSubstr("first pixel's centre"));
}

TEST_F(ControlPointFiles, NamesOfCrsInTheFirstLine) {
  EXPECT_EQ(gcp_crs("WGS84 UTM 15N"), "EPSG:32615");
  EXPECT_EQ(gcp_crs("wgs84 utm 7S\r"), "EPSG:32707");
  EXPECT_EQ(gcp_crs("EPSG:2193"), "EPSG:2193");
  EXPECT_EQ(gcp_crs("+proj=utm +zone=15 +datum=WGS84"), "+proj=utm +zone=15 +datum=WGS84 +type=crs");
  for (const char* bad : {"", "1 2 3 4 5 a.jpg", "WGS84 UTM 61N", "WGS84 UTM 15", "NAD27 somewhere"})
    EXPECT_THROW(static_cast<void>(gcp_crs(bad)), base::Error) << bad;
}

TEST_F(ControlPointFiles, UtmCoordinatesLandWhereTheyBelong) {
  // The corner of the published cloud (EPSG:32615) and the survey's origin are less than 100 m apart.
  const auto survey = survey_with({"a.jpg"});
  const auto read = read_control_points(file("gcp.txt", "EPSG:32615\n576700 5188150 160 10 10 a.jpg p\n"), survey);
  ASSERT_THAT(read.points, SizeIs(1));
  EXPECT_LT(read.points[0].p_world.head<2>().norm(), 100.0);
  EXPECT_NEAR(read.points[0].p_world.z(), 2.0, 0.01);
}

TEST_F(ControlPointFiles, RowsWithoutNamesAreJoinedByTheirPlace) {
  const auto survey = survey_with({"a.jpg", "b.jpg"});
  const auto read = read_control_points(
      file("gcp.txt",
           "WGS84\n-91.99 46.84 170 1 2 a.jpg\n-91.99 46.84 170 3 4 b.jpg\n-91.98 46.84 NaN 3 4 b.jpg\n"
           "-91.97 46.84 171 3 4 c.jpg\n"),
      survey);
  ASSERT_THAT(read.points, SizeIs(2));
  EXPECT_THAT(read.points[0].observations, SizeIs(2));
  ASSERT_THAT(read.rejects, SizeIs(2));
  EXPECT_EQ(read.rejects[0].reason, "no_height");
  EXPECT_EQ(read.rejects[1].reason, "unknown_image");
}

TEST_F(ControlPointFiles, OpensfmGroundControlOfBerlin) {
  const auto survey = survey_with({"01.jpg", "02.jpg", "03.jpg"}, 52.51896296296295, 13.400376851851851);
  const auto read = read_control_points(testing::test_data("opensfm_berlin/ground_control_points.json"), survey);
  ASSERT_THAT(read.points, SizeIs(2));
  ASSERT_THAT(read.rejects, SizeIs(1));
  EXPECT_EQ(read.rejects[0].reason, "no_position");
  const auto& first = read.points.front();
  EXPECT_EQ(first.name, "0");
  ASSERT_THAT(first.observations, SizeIs(2));
  EXPECT_NEAR(first.observations[0].pixel.x(), -0.015689 * 3264.0 + 1632.0, 1e-9);
  EXPECT_NEAR(first.observations[0].pixel.y(), -0.0625362 * 3264.0 + 1224.0, 1e-9);
}

TEST_F(ControlPointFiles, OwnTableWithSigmasAndCheckPoints) {
  const auto survey = survey_with({"a.jpg", "b.jpg"});
  const auto read = read_control_points(file("points.csv",
                                             "# crs: local\nname,x,y,z,image,x_px,y_px,sigma_xy_m,sigma_z_m,use\n"
                                             "p,1,2,3,a.jpg,10,20,0.01,0.02,control\n"
                                             "p,1,2,3,b.jpg,11,21,0.01,0.02,control\n"
                                             "q,4,5,6,b.jpg,12,22,,,check\n"),
                                        survey);
  ASSERT_THAT(read.points, SizeIs(2));
  EXPECT_EQ(read.points[0].p_world, Vec3(1, 2, 3));
  EXPECT_EQ(read.points[0].sigma_xy_m, 0.01);
  EXPECT_EQ(read.points[0].observations[0].pixel, Vec2(10, 20));
  EXPECT_FALSE(read.points[0].check_only);
  EXPECT_TRUE(read.points[1].check_only);
  EXPECT_EQ(read.points[1].sigma_z_m, 0.03);
  EXPECT_THAT(read.rejects, IsEmpty());
}

TEST_F(ControlPointFiles, PixelsOfLargerImagesAreScaled) {
  const auto survey = survey_with({"a.jpg"});
  ControlPointOptions options;
  options.image_scale = 0.4;
  const auto read = read_control_points(
      file("points.csv", "# crs: local\nname,x,y,z,image,x_px,y_px\np,1,2,3,a.jpg,8000,1000\n"), survey, options);
  EXPECT_EQ(read.points[0].observations[0].pixel, Vec2(3200, 400));
}

TEST_F(ControlPointFiles, BadInputIsNamed) {
  const auto survey = survey_with({"a.jpg", "b.jpg"});
  const auto expect = [&](const char* name, const char* text, base::ErrorCode code, const char* says) {
    try {
      static_cast<void>(read_control_points(file(name, text), survey));
      ADD_FAILURE() << "accepted: " << says;
    } catch (const base::Error& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      EXPECT_THAT(error.what(), HasSubstr(says));
    }
  };
  using Code = base::ErrorCode;
  expect("a.txt", "", Code::invalid_input, "empty");
  expect("b.txt", "WGS84\n1 2 3 4 a.jpg\n", Code::invalid_input, "line 2");
  expect("c.txt", "WGS84\n1 2 x 4 5 a.jpg\n", Code::invalid_input, "'x'");
  expect("d.txt", "1 2 3 4 5 a.jpg\n", Code::crs_mismatch, "names no CRS");
  expect("e.txt", "EPSG:99999999\n1 2 3 4 5 a.jpg\n", Code::crs_mismatch, "99999999");
  expect("f.txt", "WGS84\n-91.99 46.84 170 9000 5 a.jpg p\n", Code::invalid_input, "outside its image");
  expect("g.txt", "WGS84\n-91.99 46.84 170 1 5 a.jpg p\n-91.98 46.84 170 1 5 b.jpg p\n", Code::invalid_input,
         "different coordinates");
  expect("h.txt", "WGS84\n-91.99 46.84 170 1 5 a.jpg p\n-91.99 46.84 170 2 5 a.jpg p\n", Code::invalid_input,
         "seen twice");
  expect("i.csv", "name,x,y,z,image,x_px,y_px\np,1,2,3,a.jpg,1,2\n", Code::crs_mismatch, "no CRS");
  expect("j.csv", "# crs: local\nname,x,y,z,image,x_px\np,1,2,3,a.jpg,1\n", Code::invalid_input, "y_px");
  expect("k.json", "{\"points\": [{\"id\": \"0\"}]}", Code::invalid_input, "observations");
}

}  // namespace
}  // namespace cairn::io
