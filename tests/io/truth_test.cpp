#include "io/truth.hpp"

#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "io/survey_folder.hpp"
#include "support/data.hpp"

namespace {

using namespace cairn;
using cairn::testing::TempFolder;
using geometry::Vec3;

survey::Truth small_truth() {
  survey::Truth truth;
  truth.scene = "made up";
  truth.seed = 12;
  survey::TruthObject object;
  object.id = survey::ObjectId(1);
  object.object_class = "pbr";
  object.sought = true;
  object.cylinder = {{1.0 / 3.0, -2.5}, 0.1, 1.7, 0.8};
  object.mesh = io::truth_mesh_name(object.id);
  object.volume_m3 = 1.234567890123;
  object.centre_of_mass = Vec3(0.3, -2.4, 0.7);
  object.contact_rim = {{Vec3(0, 0, 0.1), Vec3(0.5, 0, 0.1), Vec3(0, 0.5, 0.12)}};
  truth.objects.push_back(object);
  object = {};
  object.id = survey::ObjectId(2);
  object.object_class = "tree";
  truth.objects.push_back(object);
  for (int i = 1; i <= 3; ++i) {
    survey::Frame frame;
    frame.id = survey::FrameId(i);
    frame.time_ns = 1'000'000'000LL * i;
    frame.camera = survey::CameraId(1);
    frame.T_world_camera = io::exact_pose({geometry::axis_rotation(Vec3::UnitX(), 0.3 * i), Vec3(i, 0.1 * i, 10.0)});
    truth.frames.push_back(frame);
    truth.boxes.push_back({frame.id, survey::ObjectId(1), {10.25, 20.0 / 3.0, 30, 40}, i != 2, 0.5 + 0.1 * i});
  }
  truth.detections = {{survey::DetectionId(1), survey::ObjectId(1), -1},
                      {survey::DetectionId(2), {}, 3},
                      {survey::DetectionId(3), {}, -1}};
  return truth;
}

void write(const TempFolder& folder) {
  io::write_truth(small_truth(), {{33.8, -111.9, 700.0}, survey::HeightType::ellipsoidal, ""}, folder.path());
}

TEST(Truth, ReadsBackAsWritten) {
  const TempFolder folder;
  write(folder);
  const survey::Truth truth = small_truth(), read = io::read_truth(folder / "truth.json");
  EXPECT_EQ(read.scene, truth.scene);
  EXPECT_EQ(read.seed, truth.seed);
  ASSERT_EQ(read.objects.size(), 2U);
  const auto &a = read.objects[0], &b = truth.objects[0];
  EXPECT_EQ(a.object_class, b.object_class);
  EXPECT_TRUE(a.sought);
  EXPECT_FALSE(read.objects[1].sought);
  EXPECT_EQ(a.cylinder.axis, b.cylinder.axis);
  EXPECT_EQ(a.cylinder.bottom, b.cylinder.bottom);
  EXPECT_EQ(a.cylinder.top, b.cylinder.top);
  EXPECT_EQ(a.cylinder.radius, b.cylinder.radius);
  EXPECT_EQ(a.mesh, "truth/meshes/1.ply");
  EXPECT_EQ(a.volume_m3, b.volume_m3);
  EXPECT_EQ(a.centre_of_mass, b.centre_of_mass);
  EXPECT_EQ(a.contact_rim, b.contact_rim);
  EXPECT_TRUE(a.contact_bearing.empty());
  ASSERT_EQ(read.frames.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(read.frames[i].T_world_camera.rotation, truth.frames[i].T_world_camera.rotation);
    EXPECT_EQ(read.boxes[i].box, truth.boxes[i].box);
    EXPECT_EQ(read.boxes[i].whole, truth.boxes[i].whole);
    EXPECT_EQ(read.boxes[i].visible_share, truth.boxes[i].visible_share);
    EXPECT_EQ(read.detections[i].object, truth.detections[i].object);
    EXPECT_EQ(read.detections[i].clutter, truth.detections[i].clutter);
  }
}

struct Damage {
  const char* file;
  const char* from;
  const char* to;
};

class DamagedTruth : public ::testing::TestWithParam<Damage> {};

TEST_P(DamagedTruth, IsRefusedByName) {
  const TempFolder folder;
  write(folder);
  const Damage& damage = GetParam();
  std::string text = base::read_file(folder / damage.file);
  const auto at = text.find(damage.from);
  ASSERT_NE(at, std::string::npos);
  text.replace(at, std::string(damage.from).size(), damage.to);
  base::write_file(folder / damage.file, text);
  try {
    static_cast<void>(io::read_truth(folder / "truth.json"));
    FAIL() << "read";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::invalid_input);
    EXPECT_NE(error.file().find(damage.file), std::string::npos) << error.what();
  }
}

INSTANTIATE_TEST_SUITE_P(Truth, DamagedTruth,
                         ::testing::Values(Damage{"truth.json", "\"schema_version\": 1", "\"schema_version\": 2"},
                                           Damage{"truth.json", "\"id\": 2", "\"id\": 1"},
                                           Damage{"truth.json", "\"sought\": true", "\"sought\": 1"},
                                           Damage{"truth.json", "\"top_m\": 1.7", "\"top_m\": -1.7"},
                                           Damage{"truth/boxes.csv", "1,1,10.25", "9,1,10.25"},
                                           Damage{"truth/boxes.csv", "1,1,10.25", "1,9,10.25"},
                                           Damage{"truth/boxes.csv", "1,1,10.25", "1,1,99"},
                                           Damage{"truth/boxes.csv", "0.6", "1.6"},
                                           Damage{"truth/detections.csv", "2,,3", "1,,3"},
                                           Damage{"truth/detections.csv", "1,1,", "1,7,"}));

}  // namespace
