#include "io/opensfm.hpp"

#include <gmock/gmock.h>

#include <algorithm>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "camera/projection.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using geometry::Vec2;
using geometry::Vec3;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

OpensfmModel berlin() {
  return read_opensfm(testing::test_data("opensfm_berlin"));
}

// Three photographs with OpenSfM's own reconstruction and tracks.
TEST(OpensfmBerlin, ReadsShotsPointsAndReference) {
  const auto model = berlin();
  ASSERT_EQ(model.cameras.size(), 1U);
  const auto& camera = model.cameras.front();
  EXPECT_EQ(camera.model, survey::CameraModel::radial);
  EXPECT_EQ(camera.width_px, 3264);
  EXPECT_DOUBLE_EQ(camera.fx_px, 0.8696658484855359 * 3264.0);
  EXPECT_DOUBLE_EQ(camera.cx_px, 1632.0);
  EXPECT_DOUBLE_EQ(camera.cy_px, 1224.0);
  ASSERT_EQ(model.shots.size(), 3U);
  EXPECT_EQ(model.shots[0].image, "01.jpg");
  EXPECT_EQ(model.points.size(), 1430U);
  ASSERT_TRUE(model.reference);
  EXPECT_DOUBLE_EQ(model.reference->latitude_deg, 52.51896296296295);
  EXPECT_THAT(model.left_out, IsEmpty());
}

// The track pixels against the 3-D points: proves direction of the poses, pixel origin, distortion and ids at once.
TEST(OpensfmBerlin, TracksReproject) {
  const auto model = berlin();
  std::vector<double> residuals;
  for (const auto& point : model.points) {
    EXPECT_GE(point.observations.size(), 2U);
    for (const auto& seen : point.observations) {
      const auto& shot = model.shots[seen.shot];
      const auto at = camera::project_world(model.cameras[shot.camera], shot.T_world_camera, point.position);
      ASSERT_TRUE(at);
      residuals.push_back((*at - seen.pixel).norm());
    }
  }
  ASSERT_EQ(residuals.size(), 3082U);
  std::sort(residuals.begin(), residuals.end());
  // Computed independently from the file: median 0.80, 95 % 3.92 px of 3264.
  EXPECT_NEAR(residuals[residuals.size() / 2], 0.80, 0.01);
  EXPECT_NEAR(residuals[residuals.size() * 95 / 100], 3.92, 0.05);
}

constexpr const char* kReconstruction =
    R"([{"cameras": {"c": {"projection_type": "TYPE", "width": 400, "height": 300, PARAMETERS}},
  "shots": {"a.jpg": {"rotation": [0, 0, 0], "translation": [1, 2, 3], "camera": "c"}},
  "points": {"7": {"coordinates": [0.5, 1.0, 9.0]}}}])";

std::string reconstruction(const std::string& type, const std::string& parameters) {
  std::string text = kReconstruction;
  text.replace(text.find("TYPE"), 4, type);
  text.replace(text.find("PARAMETERS"), 10, parameters);
  return text;
}

OpensfmModel parsed(const std::string& text, const std::string& tracks = {}) {
  return parse_opensfm(text, tracks, "r.json", "tracks.csv");
}

TEST(Opensfm, PoseIsInvertedAndPixelsAreCornerBased) {
  const auto model =
      parsed(reconstruction("perspective", R"("focal": 0.8, "k1": 0.1, "k2": 0.02)"), "a.jpg\t7\t0\t0.25\t-0.125\t1\n");
  EXPECT_EQ(model.shots[0].T_world_camera.translation, Vec3(-1.0, -2.0, -3.0));
  ASSERT_EQ(model.points[0].observations.size(), 1U);
  // Longer side 400: u = 0.25 * 400 + 200, v = -0.125 * 400 + 150.
  EXPECT_EQ(model.points[0].observations[0].pixel, Vec2(300.0, 100.0));
  EXPECT_FALSE(model.reference);
}

TEST(Opensfm, BrownAndFisheyeCameras) {
  const auto brown = parsed(reconstruction("brown", R"("focal_x": 0.8, "focal_y": 0.81, "c_x": 0.01, "c_y": -0.02,
      "k1": 0.1, "k2": 0.2, "k3": 0.3, "p1": 0.4, "p2": 0.5)"))
                         .cameras.front();
  EXPECT_EQ(brown.model, survey::CameraModel::brown);
  EXPECT_DOUBLE_EQ(brown.fx_px, 320.0);
  EXPECT_DOUBLE_EQ(brown.fy_px, 324.0);
  EXPECT_DOUBLE_EQ(brown.cx_px, 204.0);
  EXPECT_DOUBLE_EQ(brown.cy_px, 142.0);
  EXPECT_THAT((std::vector<double>{brown.k1, brown.k2, brown.k3, brown.p1, brown.p2}),
              ElementsAre(0.1, 0.2, 0.3, 0.4, 0.5));
  const auto fisheye = parsed(reconstruction("fisheye", R"("focal": 0.5, "k1": 0.1, "k2": 0.2)")).cameras.front();
  EXPECT_EQ(fisheye.model, survey::CameraModel::fisheye);
  EXPECT_DOUBLE_EQ(fisheye.fx_px, 200.0);
}

TEST(Opensfm, TheLargestReconstructionIsTakenAndTheOthersNamed) {
  const std::string one = reconstruction("perspective", R"("focal": 0.8)");
  const std::string two =
      R"({"cameras": {"c": {"projection_type": "perspective", "width": 400, "height": 300, "focal": 1}},
    "shots": {"b.jpg": {"rotation": [0,0,0], "translation": [0,0,0], "camera": "c"},
              "c.jpg": {"rotation": [0,0,0], "translation": [0,0,0], "camera": "c"}}, "points": {}})";
  const auto model = parsed(one.substr(0, one.size() - 1) + "," + two + "]");
  EXPECT_EQ(model.shots.size(), 2U);
  EXPECT_THAT(model.left_out, ElementsAre("a.jpg"));
}

void expect_refused(const std::string& text, const std::string& tracks, const std::string& says) {
  try {
    static_cast<void>(parsed(text, tracks));
    FAIL() << "accepted: " << says;
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::invalid_input);
    EXPECT_THAT(error.what(), HasSubstr(says));
  }
}

TEST(Opensfm, BadInputIsNamed) {
  const std::string good = reconstruction("perspective", R"("focal": 0.8)");
  expect_refused("{}", "", "not an OpenSfM reconstruction");
  expect_refused("[]", "", "not an OpenSfM reconstruction");
  expect_refused(good.substr(0, 80), "", "r.json");
  expect_refused(reconstruction("spherical", R"("focal": 0.8)"), "", "spherical");
  expect_refused(reconstruction("perspective", R"("k1": 0.8)"), "", "focal");
  expect_refused(reconstruction("perspective", R"("focal": -1)"), "", "not positive");
  auto other = good;
  other.replace(other.find(R"("camera": "c")"), 13, R"("camera": "d")");
  expect_refused(other, "", "a.jpg");
  auto id = good;
  id.replace(id.find("\"7\""), 3, "\"x\"");
  expect_refused(id, "", "'x'");
  expect_refused(good, "OPENSFM_TRACKS_VERSION_v2\na.jpg\t7\t0\n", "line 2");
  expect_refused(good, "a.jpg\t7\t0\tnan\t0\n", "line 1");
  expect_refused(good, "a.jpg\t7\t0\t0\t0\na.jpg\t7\t1\t0\t0\n", "track 7");
}

TEST(Opensfm, AMissingFileIsNotFound) {
  EXPECT_THROW(static_cast<void>(read_opensfm(testing::test_data("brighton_beach"))), base::Error);
}

}  // namespace
}  // namespace cairn::io
