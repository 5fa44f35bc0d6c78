#include "io/survey_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <functional>
#include <string>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "base/random.hpp"
#include "io/survey_json.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using ::testing::HasSubstr;

geometry::RigidTransform random_pose(base::Random& random) {
  const geometry::Quaternion q{random.normal(), random.normal(), random.normal(), random.normal()};
  return exact_pose({geometry::rotation_matrix(q), {random.normal(), 100.0 * random.normal(), 40.0 + random.normal()}});
}

survey::Survey example() {
  survey::Survey s;
  s.manifest.name = "example, with \"quotes\"";
  s.manifest.origin = {{46.8426, -91.994, 158.0}, survey::HeightType::orthometric, "egm96"};
  s.manifest.time_base = base::TimeBase::gps;
  survey::Camera camera;
  camera.id = survey::CameraId(3);
  camera.name = "DJI FC300S";
  camera.model = survey::CameraModel::brown;
  camera.width_px = 1600;
  camera.height_px = 900;
  camera.fx_px = 914.2857142857143;
  camera.fy_px = 914.1;
  camera.cx_px = 800.25;
  camera.cy_px = 450.125;
  camera.k1 = 0.0039291586793227425;
  camera.k2 = 0.1;
  camera.k3 = -1e-7;
  camera.p1 = 1e-5;
  camera.p2 = -0.3;
  s.manifest.cameras = {camera};
  survey::Source cloud;
  cloud.kind = "cloud";
  cloud.path = "../model.las";
  cloud.convention = "EPSG:32615 as declared in the file.";
  cloud.confidence = survey::Confidence::inferred;
  cloud.crs = "EPSG:32615";
  cloud.height_type = survey::HeightType::ellipsoidal;
  cloud.T_world_source =
      geometry::Similarity{1.0006, geometry::rotation_matrix({0.9999, 0.001, -0.002, 0.003}), {0.57, -0.01, 0.93}};
  survey::Source ties = cloud;
  ties.kind = "ties";
  ties.T_world_source.reset();
  s.manifest.sources = {cloud, ties};
  s.manifest.notes = {"First sentence.", "Second, with a comma."};
  base::Random random(7, "survey", 0);
  for (int i = 0; i < 20; ++i) {
    survey::Frame frame;
    frame.id = survey::FrameId(10 + 3 * i);
    frame.time_ns = 1466699519000000001 + i;
    frame.camera = camera.id;
    frame.image = i == 0 ? "" : "images/=odd, name " + std::to_string(i) + ".jpg";
    frame.T_world_camera = random_pose(random);
    frame.sigma_xy_m = random.uniform();
    frame.sigma_z_m = random.uniform();
    frame.sigma_rot_deg = random.uniform();
    s.frames.push_back(frame);
    survey::Detection d;
    d.id = survey::DetectionId(i);
    d.frame = frame.id;
    d.object_class = i % 2 == 0 ? "boulder" : "-tree";
    d.score = random.uniform();
    d.box.xmin = random.uniform(0, 700);
    d.box.ymin = random.uniform(0, 400);
    d.box.xmax = random.uniform(700, 1600);
    d.box.ymax = random.uniform(400, 900);
    s.detections.push_back(d);
    survey::TiePoint tie;
    tie.id = survey::TiePointId(100 + i);
    tie.p_world = {random.normal(), random.normal(), random.normal()};
    for (const auto& seen : s.frames) tie.observations.push_back({seen.id, {random.uniform(), random.uniform()}});
    s.ties.push_back(tie);
  }
  return s;
}

void expect_same(const geometry::Similarity& a, const geometry::Similarity& b) {
  EXPECT_EQ(a.scale, b.scale);
  EXPECT_EQ(a.rotation, b.rotation);
  EXPECT_EQ(a.translation, b.translation);
}

// Every field, bit for bit.
void expect_same(const survey::Survey& a, const survey::Survey& b) {
  EXPECT_EQ(a.manifest.name, b.manifest.name);
  EXPECT_EQ(a.manifest.origin.position, b.manifest.origin.position);
  EXPECT_EQ(a.manifest.origin.height_type, b.manifest.origin.height_type);
  EXPECT_EQ(a.manifest.origin.geoid, b.manifest.origin.geoid);
  EXPECT_EQ(a.manifest.time_base, b.manifest.time_base);
  EXPECT_EQ(a.manifest.cameras, b.manifest.cameras);
  EXPECT_EQ(a.manifest.notes, b.manifest.notes);
  ASSERT_EQ(a.manifest.sources.size(), b.manifest.sources.size());
  for (std::size_t i = 0; i < a.manifest.sources.size(); ++i) {
    const auto &p = a.manifest.sources[i], &q = b.manifest.sources[i];
    EXPECT_EQ(p.kind, q.kind);
    EXPECT_EQ(p.path, q.path);
    EXPECT_EQ(p.convention, q.convention);
    EXPECT_EQ(p.confidence, q.confidence);
    EXPECT_EQ(p.crs, q.crs);
    EXPECT_EQ(p.height_type, q.height_type);
    ASSERT_EQ(p.T_world_source.has_value(), q.T_world_source.has_value());
    if (p.T_world_source) expect_same(*p.T_world_source, *q.T_world_source);
  }
  ASSERT_EQ(a.frames.size(), b.frames.size());
  for (std::size_t i = 0; i < a.frames.size(); ++i) {
    const auto &p = a.frames[i], &q = b.frames[i];
    EXPECT_EQ(p.id, q.id);
    EXPECT_EQ(p.time_ns, q.time_ns);
    EXPECT_EQ(p.camera, q.camera);
    EXPECT_EQ(p.image, q.image);
    EXPECT_EQ(p.T_world_camera.rotation, q.T_world_camera.rotation) << "frame " << i;
    EXPECT_EQ(p.T_world_camera.translation, q.T_world_camera.translation);
    EXPECT_EQ(p.sigma_xy_m, q.sigma_xy_m);
    EXPECT_EQ(p.sigma_z_m, q.sigma_z_m);
    EXPECT_EQ(p.sigma_rot_deg, q.sigma_rot_deg);
  }
  EXPECT_EQ(a.detections, b.detections);
  ASSERT_EQ(a.ties.size(), b.ties.size());
  for (std::size_t i = 0; i < a.ties.size(); ++i) {
    EXPECT_EQ(a.ties[i].id, b.ties[i].id);
    EXPECT_EQ(a.ties[i].p_world, b.ties[i].p_world);
    ASSERT_EQ(a.ties[i].observations.size(), b.ties[i].observations.size());
    for (std::size_t k = 0; k < a.ties[i].observations.size(); ++k) {
      EXPECT_EQ(a.ties[i].observations[k].frame, b.ties[i].observations[k].frame);
      EXPECT_EQ(a.ties[i].observations[k].pixel, b.ties[i].observations[k].pixel);
    }
  }
}

TEST(SurveyFolder, ReadGivesBackWhatWasWrittenBitForBit) {
  const testing::TempFolder folder;
  const survey::Survey written = example();
  write_survey(written, folder.path());
  expect_same(read_survey(folder.path()), written);
}

TEST(SurveyFolder, WritingWhatWasReadGivesTheSameBytes) {
  const testing::TempFolder first, second;
  write_survey(example(), first.path());
  write_survey(read_survey(first.path()), second.path());
  for (const auto* name : {"survey.json", "frames.csv", "detections.csv", "tie_points.csv", "tie_observations.csv"})
    EXPECT_EQ(base::read_file(first / name), base::read_file(second / name)) << name;
}

TEST(SurveyFolder, AnyPoseFromAQuaternionIsExact) {
  const testing::TempFolder folder;
  survey::Survey s = example();
  s.detections.clear();
  s.ties.clear();
  s.frames.resize(1);
  base::Random random(11, "poses", 0);
  constexpr int kPoses = 5000;
  for (int i = 0; i < kPoses; ++i) {
    survey::Frame frame = s.frames.front();
    frame.id = survey::FrameId(1000 + i);
    frame.T_world_camera = random_pose(random);
    s.frames.push_back(frame);
  }
  write_survey(s, folder.path());
  EXPECT_FALSE(std::filesystem::exists(folder / "detections.csv"));
  expect_same(read_survey(folder.path()), s);
}

// Quaternions of few digits, as other programs write them: what was read must survive being written.
TEST(SurveyFolder, PosesReadFromShortTextAreStable) {
  const testing::TempFolder first, second;
  write_survey(example(), first.path());
  base::Random random(12, "poses", 0);
  std::string table = "frame_id,time_ns,camera_id,image,x_m,y_m,z_m,qw,qx,qy,qz,sigma_xy_m,sigma_z_m,sigma_rot_deg\n";
  constexpr int kPoses = 2000;
  for (int i = 0; i < kPoses; ++i) {
    table += std::to_string(i) + ",0,3,,1,2,3";
    const geometry::Quaternion q = geometry::quaternion(random_pose(random).rotation);
    for (const double value : {q.qw, q.qx, q.qy, q.qz}) table += "," + base::to_fixed(value, 4 + i % 12);
    table += ",,,\n";
  }
  for (const auto* name : {"detections.csv", "tie_points.csv", "tie_observations.csv"})
    std::filesystem::remove(first / name);
  base::write_file(first / "frames.csv", table);
  const survey::Survey s = read_survey(first.path());
  ASSERT_EQ(s.frames.size(), static_cast<std::size_t>(kPoses));
  write_survey(s, second.path());
  expect_same(read_survey(second.path()), s);
}

TEST(SurveyFolder, PosesThatCameFromNoQuaternionAreKeptToRounding) {
  const testing::TempFolder folder;
  survey::Survey s = example();
  const geometry::Mat3 turned =
      s.frames[0].T_world_camera.rotation * geometry::axis_rotation(geometry::Vec3(1, 2, 3).normalized(), 0.7);
  s.frames[0].T_world_camera.rotation = turned;
  write_survey(s, folder.path());
  constexpr double kRounding = 2e-15;  // elements of a rotation: some units in the last place
  EXPECT_LT((read_survey(folder.path()).frames[0].T_world_camera.rotation - turned).cwiseAbs().maxCoeff(), kRounding);
}

TEST(SurveyFolder, RowsMayStandInAnyOrder) {
  const testing::TempFolder folder;
  write_survey(example(), folder.path());
  std::string text = base::read_file(folder / "frames.csv");
  const auto header_end = text.find('\n') + 1, first_end = text.find('\n', header_end) + 1;
  const std::string first = text.substr(header_end, first_end - header_end);
  text.erase(header_end, first.size());
  base::write_file(folder / "frames.csv", text + first);
  expect_same(read_survey(folder.path()), example());
}

// One edit of a sound survey, and what must be said about it.
struct Fault {
  std::string name, file, find, replace, message;
  base::ErrorCode code = base::ErrorCode::invalid_input;
};

class SurveyFolderFault : public ::testing::TestWithParam<Fault> {};

constexpr const char* kFrames =
    "frame_id,time_ns,camera_id,image,x_m,y_m,z_m,qw,qx,qy,qz,sigma_xy_m,sigma_z_m,sigma_rot_deg\n"
    "1,0,3,a.jpg,0,0,40,0,1,0,0,,,\n2,0,3,b.jpg,5,0,40,0,1,0,0,0.1,0.2,0.3\n";
constexpr const char* kDetections =
    "detection_id,frame_id,class,score,xmin_px,ymin_px,xmax_px,ymax_px\n1,1,boulder,0.5,10,20,30,40\n2,2,car,1,10,20,"
    "30,40\n";

void write_small(const testing::TempFolder& folder) {
  survey::Survey s;
  s.manifest = example().manifest;
  write_survey(s, folder.path());
  base::write_file(folder / "frames.csv", kFrames);
  base::write_file(folder / "detections.csv", kDetections);
  base::write_file(folder / "tie_points.csv", "tie_id,x_m,y_m,z_m\n5,1,2,3\n");
  base::write_file(folder / "tie_observations.csv", "tie_id,frame_id,u_px,v_px\n5,1,100.5,200.5\n5,2,90,80\n");
}

TEST(SurveyFolder, SmallExampleIsSound) {
  const testing::TempFolder folder;
  write_small(folder);
  const survey::Survey s = read_survey(folder.path());
  EXPECT_EQ(s.frames.size(), 2U);
  EXPECT_EQ(s.frames[0].sigma_z_m, 0.0);
  EXPECT_EQ(s.detections.size(), 2U);
  ASSERT_EQ(s.ties.size(), 1U);
  EXPECT_EQ(s.ties[0].observations.size(), 2U);
}

TEST_P(SurveyFolderFault, IsRefusedWithFileRecordAndValue) {
  const Fault& fault = GetParam();
  const testing::TempFolder folder;
  write_small(folder);
  std::string text = base::read_file(folder / fault.file);
  const auto at = text.find(fault.find);
  ASSERT_NE(at, std::string::npos) << "the fault does not apply";
  text.replace(at, fault.find.size(), fault.replace);
  base::write_file(folder / fault.file, text);
  try {
    (void)read_survey(folder.path());
    FAIL() << "accepted";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), fault.code) << error.what();
    EXPECT_THAT(error.what(), HasSubstr(fault.message));
    EXPECT_THAT(error.file(), HasSubstr(fault.file));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Faults, SurveyFolderFault,
    ::testing::Values(
        Fault{"schema", "survey.json", "\"schema_version\": 1", "\"schema_version\": 99", "unknown schema version"},
        Fault{"malformed", "survey.json", "\"origin\"", "origin", "line 4"},
        Fault{"no_origin", "survey.json", "\"origin\"", "\"orgin\"", "lacks the member 'origin'"},
        Fault{"latitude", "survey.json", "46.8426", "146.8426", "latitude out of range", base::ErrorCode::crs_mismatch},
        Fault{"height_type", "survey.json", "\"height_type\": \"orthometric\"", "\"height_type\": \"msl\"", "'msl'"},
        Fault{"time_base", "survey.json", "\"gps\"", "\"tai\"", "'tai'"},
        Fault{"model", "survey.json", "\"brown\"", "\"spherical\"", "'spherical'"},
        Fault{"focal", "survey.json", "914.1", "0", "focal length is not positive"},
        Fault{"size", "survey.json", "\"width_px\": 1600", "\"width_px\": -1600", "image size out of range"},
        Fault{"rotation", "survey.json", "\"scale\": 1.0006", "\"scale\": -1", "scale is not positive"},
        Fault{"frame_camera", "frames.csv", "2,0,3,b", "2,0,4,b", "frame of an unknown camera"},
        Fault{"frame_without_camera", "frames.csv", "2,0,3,b", "2,0,,b", "not a whole number"},
        Fault{"frame_twice", "frames.csv", "\n2,", "\n1,", "id appears twice"},
        Fault{"pose_nan", "frames.csv", "b.jpg,5,0", "b.jpg,nan,0", "line 3, column x_m: number is not finite"},
        Fault{"pose_missing", "frames.csv", "b.jpg,5,0", "b.jpg,,0", "line 3, column x_m: not a number"},
        Fault{"zero_quaternion", "frames.csv", "5,0,40,0,1,0,0", "5,0,40,0,0,0,0", "|q| = 0"},
        Fault{"long_quaternion", "frames.csv", "5,0,40,0,1,0,0", "5,0,40,0.9,1,0,0",
              "quaternion is not of unit length"},
        Fault{"huge_quaternion", "frames.csv", "5,0,40,0,1,0,0", "5,0,40,1e300,1e300,0,0", "quaternion"},
        Fault{"sigma", "frames.csv", "0.1,0.2,0.3", "-0.1,0.2,0.3", "standard deviation is negative"},
        Fault{"column", "frames.csv", "qx", "quat_x", "column 'qx' is missing"},
        Fault{"detection_frame", "detections.csv", "2,2,car", "2,99,car", "detection of an unknown frame"},
        Fault{"detection_twice", "detections.csv", "2,2,car", "1,2,car", "id appears twice"},
        Fault{"detection_class", "detections.csv", "2,2,car", "2,2,", "value is missing"},
        Fault{"box_x", "detections.csv", "1,10,20,30,40", "1,30.5,20,30,40", "box ends before it begins"},
        Fault{"box_y", "detections.csv", "1,10,20,30,40", "1,10,50,30,40", "box ends before it begins"},
        Fault{"score", "detections.csv", "car,1,", "car,1.5,", "score out of range"},
        Fault{"tie_unknown", "tie_observations.csv", "\n5,2", "\n6,2", "unknown tie point"},
        Fault{"tie_frame", "tie_observations.csv", "\n5,2", "\n5,7", "observation of an unknown frame"},
        Fault{"tie_point", "tie_points.csv", "5,1,2,3", "5,1,inf,3", "number is not finite"}),
    [](const auto& fault) { return fault.param.name; });

TEST(SurveyFolder, DuplicateCameraIsRefused) {
  const testing::TempFolder folder;
  survey::Survey s = example();
  s.manifest.cameras.push_back(s.manifest.cameras.front());
  write_survey(s, folder.path());
  EXPECT_THROW((void)read_survey(folder.path()), base::Error);
}

TEST(SurveyFolder, MissingFolderIsNotFound) {
  try {
    (void)read_survey("/nonexistent/survey");
    FAIL();
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::not_found);
  }
}

TEST(SurveyFolder, NonFinitePoseIsNotWritten) {
  const testing::TempFolder folder;
  survey::Survey s = example();
  s.frames[3].T_world_camera.translation.x() = std::nan("");
  EXPECT_THROW(write_survey(s, folder.path()), base::Error);
}

TEST(FileReference, IsRelativeInsideAndBesideTheSurveyAndAbsoluteElsewhere) {
  const testing::TempFolder folder;
  const auto survey = folder / "survey";
  EXPECT_EQ(file_reference(survey / "images/a.jpg", survey), "images/a.jpg");
  EXPECT_EQ(file_reference(folder / "photos/a.jpg", survey), "../photos/a.jpg");
  EXPECT_EQ(file_reference(folder / "photos/a.jpg", survey / ""), "../photos/a.jpg") << "trailing slash";
  EXPECT_EQ(file_reference("/elsewhere/a.jpg", survey), "/elsewhere/a.jpg");
  EXPECT_EQ(resolve_reference("../photos/a.jpg", survey), folder / "photos/a.jpg");
  EXPECT_EQ(resolve_reference("/elsewhere/a.jpg", survey), "/elsewhere/a.jpg");
  EXPECT_EQ(resolve_reference("", survey), "");
}

}  // namespace
}  // namespace cairn::io
