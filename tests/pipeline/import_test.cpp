#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "base/angle.hpp"
#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "camera/projection.hpp"
#include "geodesy/crs.hpp"
#include "geodesy/local_frame.hpp"
#include "io/survey_folder.hpp"
#include "pipeline/import_colmap.hpp"
#include "pipeline/import_csv.hpp"
#include "pipeline/import_dji.hpp"
#include "support/data.hpp"
#include "support/jpeg.hpp"

namespace cairn::pipeline {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::TempFolder;

const fs::path kBeach = testing::sample("brighton_beach");
const geometry::Geodetic kOrigin{46.8426, -91.9940, 158.0};
constexpr double kTakeoff = 158.5;  // m: the absolute less the relative altitude of every photograph

// Runs an importer as the command would; gives the survey back as read from disk.
template <typename Inputs, typename Import>
survey::Survey run(Inputs in, Import&& import, Outcome* outcome = nullptr) {
  const TempFolder folder;
  const fs::path out = folder / "survey";
  fs::create_directories(out);
  in.common.survey_folder = out;
  base::RunContext ctx;
  Outcome result = import(in, out, ctx);
  if (outcome != nullptr) *outcome = std::move(result);
  return io::read_survey(out);
}

base::Error error_of(const std::function<void()>& body) {
  try {
    body();
  } catch (const base::Error& error) {
    return error;
  }
  ADD_FAILURE() << "nothing was thrown";
  return {base::ErrorCode::internal, "nothing was thrown"};
}

ImportColmapInputs colmap_inputs() {
  ImportColmapInputs in;
  in.common.origin = kOrigin;
  in.common.height_type = survey::HeightType::ellipsoidal;
  in.model = kBeach / "colmap_enu";
  in.images = kBeach / "images_1600";
  in.scale_images = 0.4;
  return in;
}

ImportDjiInputs dji_inputs() {
  ImportDjiInputs in;
  in.images = kBeach / "images_1600";
  in.takeoff_height_m = kTakeoff;
  return in;
}

double mean_reprojection(const survey::Survey& s) {
  double sum = 0.0;
  std::size_t count = 0;
  for (const auto& tie : s.ties)
    for (const auto& seen : tie.observations) {
      const auto* frame = s.frame(seen.frame);
      const auto pixel = camera::project_world(*s.camera(frame->camera), frame->T_world_camera, tie.p_world);
      if (!pixel) return HUGE_VAL;
      sum += (*pixel - seen.pixel).norm();
      ++count;
    }
  return sum / static_cast<double>(count);
}

TEST(ImportColmap, BrightonBeachInThePixelsOfTheImageFiles) {
  ImportColmapInputs in = colmap_inputs();
  in.common.detections = kBeach / "detections.csv";
  in.common.cloud = kBeach / "model.las";
  in.common.similarity = kBeach / "enu_frame.json";
  const survey::Survey s = run(in, import_colmap);
  ASSERT_EQ(s.frames.size(), 18U);
  EXPECT_EQ(s.frames.front().id.value, 18) << "ids are the numbers of the photographs";
  EXPECT_EQ(s.manifest.origin.position, kOrigin);
  ASSERT_EQ(s.manifest.cameras.size(), 1U);
  EXPECT_EQ(s.manifest.cameras[0].width_px, 1600);
  EXPECT_EQ(s.manifest.cameras[0].height_px, 900);
  constexpr double kRounding = 1e-9;  // px
  EXPECT_NEAR(s.manifest.cameras[0].fx_px, 2285.7142857142858 * 0.4, kRounding);
  EXPECT_EQ(s.ties.size(), 4881U);
  // 0.8193 px over all observations of the originals, here in pixels 2.5 times as large.
  EXPECT_NEAR(mean_reprojection(s), 0.8193 * 0.4, 1e-3);
  ASSERT_EQ(s.detections.size(), 314U);
  EXPECT_EQ(s.detections[0].id.value, 1);
  EXPECT_EQ(s.detections[0].frame.value, 18);
  EXPECT_NEAR(s.detections[0].box.xmin, 3679.6 * 0.4, kRounding);
  EXPECT_EQ(s.detections[0].object_class, "boulder");
  const survey::Source* cloud = s.source("cloud");
  ASSERT_NE(cloud, nullptr);
  EXPECT_EQ(cloud->crs, "EPSG:32615");
  ASSERT_TRUE(cloud->T_world_source);
  // X_cloud = s R X + t, so a point of the cloud goes back by the inverse; the README gives the shift.
  const geometry::Vec3 moved = *cloud->T_world_source * geometry::Vec3::Zero();
  EXPECT_NEAR(moved.x(), -0.578, 0.01);
  EXPECT_NEAR(moved.z(), -0.937, 0.01);
  EXPECT_NEAR(cloud->T_world_source->scale, 1.0 / 0.9993635800737055, 1e-12);
  EXPECT_NE(s.frames[0].time_ns, 0) << "capture times come from EXIF";
}

TEST(ImportColmap, ScaleIsTakenFromTheImagesWhereItIsNotGiven) {
  ImportColmapInputs in = colmap_inputs();
  in.scale_images.reset();
  const survey::Survey s = run(in, import_colmap);
  EXPECT_EQ(s.manifest.cameras[0].width_px, 1600);
  EXPECT_EQ(s.source("images")->confidence, survey::Confidence::inferred);
}

TEST(ImportColmap, WrongScaleIsRefused) {
  ImportColmapInputs in = colmap_inputs();
  in.scale_images = 0.5;
  const auto error = error_of([&] { (void)run(in, import_colmap); });
  EXPECT_EQ(error.code(), base::ErrorCode::failed_precondition);
  EXPECT_THAT(error.what(), AllOf(HasSubstr("1600 x 900"), HasSubstr(".JPG"), HasSubstr("--scale-images")));
}

TEST(ImportColmap, MissingImagesAreAllNamed) {
  const TempFolder folder;
  for (const auto& image : list_images(kBeach / "images_1600")) {
    const std::string name = image.filename().string();
    if (name != "DJI_0020.JPG" && name != "DJI_0035.JPG") fs::create_symlink(image, folder / name);
  }
  ImportColmapInputs in = colmap_inputs();
  in.images = folder.path();
  const auto error = error_of([&] { (void)run(in, import_colmap); });
  EXPECT_EQ(base::exit_code(error.code()), base::ExitCode::invalid_input);
  EXPECT_THAT(error.what(), AllOf(HasSubstr("2 of 18"), HasSubstr("DJI_0020.JPG"), HasSubstr("DJI_0035.JPG")));
}

TEST(ImportColmap, UnreadableImageIsNamed) {
  const TempFolder folder;
  for (const auto& image : list_images(kBeach / "images_1600"))
    if (image.filename() != "DJI_0020.JPG") fs::create_symlink(image, folder.path() / image.filename());
  base::write_file(folder / "DJI_0020.JPG", "this is not a photograph");
  ImportColmapInputs in = colmap_inputs();
  in.images = folder.path();
  const auto error = error_of([&] { (void)run(in, import_colmap); });
  EXPECT_EQ(base::exit_code(error.code()), base::ExitCode::invalid_input);
  EXPECT_THAT(error.what(), HasSubstr("DJI_0020.JPG"));
}

TEST(ImportColmap, OriginAndHeightTypeAreNeeded) {
  ImportColmapInputs in = colmap_inputs();
  in.common.height_type.reset();
  EXPECT_EQ(error_of([&] { (void)run(in, import_colmap); }).code(), base::ErrorCode::invalid_argument);
}

struct DetectionFault {
  std::string name, row, message;
};
class ImportDetectionFault : public ::testing::TestWithParam<DetectionFault> {};

TEST_P(ImportDetectionFault, IsRefusedWithLine) {
  const TempFolder folder;
  base::write_file(
      folder / "d.csv",
      "image,class,xmin_px,ymin_px,xmax_px,ymax_px,score\nDJI_0018.JPG,car,1,2,3,4,0.5\n" + GetParam().row + "\n");
  ImportColmapInputs in = colmap_inputs();
  in.common.detections = folder / "d.csv";
  const auto error = error_of([&] { (void)run(in, import_colmap); });
  EXPECT_EQ(base::exit_code(error.code()), base::ExitCode::invalid_input);
  EXPECT_THAT(error.what(), AllOf(HasSubstr("d.csv, line 3"), HasSubstr(GetParam().message)));
}

INSTANTIATE_TEST_SUITE_P(
    Faults, ImportDetectionFault,
    ::testing::Values(DetectionFault{"unknown_frame", "DJI_0099.JPG,car,1,2,3,4,0.5", "unknown frame"},
                      DetectionFault{"no_class", "DJI_0018.JPG,,1,2,3,4,0.5", "value is missing"},
                      DetectionFault{"nan", "DJI_0018.JPG,car,nan,2,3,4,0.5", "not finite"},
                      DetectionFault{"inside_out", "DJI_0018.JPG,car,3,2,1,4,0.5", "before it begins"},
                      DetectionFault{"score", "DJI_0018.JPG,car,1,2,3,4,50", "score out of range"},
                      DetectionFault{"short_row", "DJI_0018.JPG,car,1,2,3", "wrong number of cells"}),
    [](const auto& fault) { return fault.param.name; });

TEST(ImportDetections, ScaleCanBeOverridden) {
  ImportColmapInputs in = colmap_inputs();
  in.common.detections = kBeach / "detections.csv";
  in.common.detections_scale = 1.0;
  EXPECT_EQ(run(in, import_colmap).detections[0].box.xmin, 3679.6);
}

TEST(ImportCloud, SimilarityOfAnotherOriginIsRefused) {
  ImportColmapInputs in = colmap_inputs();
  in.common.cloud = kBeach / "model.las";
  in.common.similarity = kBeach / "enu_frame.json";
  in.common.origin->latitude_deg += 1e-4;
  EXPECT_EQ(error_of([&] { (void)run(in, import_colmap); }).code(), base::ErrorCode::crs_mismatch);
}

TEST(ImportCloud, PlainSimilarityNamesItsDirection) {
  const TempFolder folder;
  const survey::Origin origin{kOrigin, survey::HeightType::ellipsoidal, {}};
  const std::string body =
      R"("scale": 2, "quaternion": {"qw": 0, "qx": 0, "qy": 0, "qz": 1}, "translation_m": [1, 2, 3])";
  const auto read = [&](const std::string& direction) {
    base::write_file(folder / "s.json", "{" + body + direction + "}");
    return read_similarity(folder / "s.json", origin);
  };
  const geometry::Vec3 p(10, 20, 30);
  const geometry::Vec3 expected(-19, -38, 63);  // 2 R p + t with a half turn about z
  EXPECT_LT((read(", \"direction\": \"source_to_world\"") * p - expected).norm(), 1e-12);
  EXPECT_LT((read(", \"direction\": \"world_to_source\"") * expected - p).norm(), 1e-12);
  EXPECT_THAT(error_of([&] { (void)read(""); }).what(), HasSubstr("direction"));
  EXPECT_THAT(error_of([&] { (void)read(", \"direction\": \"up\""); }).what(), HasSubstr("'up'"));
}

TEST(ImportCloud, GivenCrsIsChecked) {
  ImportColmapInputs in = colmap_inputs();
  in.common.cloud = kBeach / "model.las";
  in.common.cloud_crs = "EPSG:999999";
  EXPECT_EQ(base::exit_code(error_of([&] { (void)run(in, import_colmap); }).code()), base::ExitCode::crs_or_grid);
  in.common.cloud_crs = "local";
  EXPECT_EQ(run(in, import_colmap).source("cloud")->crs, "local");
}

// Against the reconstruction, which knows nothing of the gimbal: position within GPS error, attitude
// within what the README states (yaw up to 3.6, axis up to 2.4 degrees).
TEST(ImportDji, BrightonBeachAgreesWithTheReconstruction) {
  ImportDjiInputs in = dji_inputs();
  in.rotate = "DJI_0024-DJI_0029";
  in.common.origin = kOrigin;
  in.common.height_type = survey::HeightType::ellipsoidal;
  const survey::Survey dji = run(in, import_dji);
  const survey::Survey reference = run(colmap_inputs(), import_colmap);
  ASSERT_EQ(dji.frames.size(), 18U);
  constexpr double kGpsError = 1.1, kAttitudeDeg = 5.0;  // m: "at most 1.0 m" in 3-D; yaw and tilt together
  for (const auto& frame : dji.frames) {
    const auto& T = reference.frame(frame.id)->T_world_camera;
    EXPECT_LT((frame.T_world_camera.translation - T.translation).norm(), kGpsError) << frame.id.value;
    EXPECT_LT(base::rad_to_deg(geometry::rotation_angle(T.rotation.transpose() * frame.T_world_camera.rotation)),
              kAttitudeDeg)
        << frame.id.value;
    EXPECT_EQ(frame.time_ns, reference.frame(frame.id)->time_ns);
    EXPECT_EQ(frame.sigma_xy_m, kGnssSigmaXyM);
  }
  EXPECT_EQ(dji.manifest.time_base, base::TimeBase::unknown);
  EXPECT_EQ(dji.manifest.origin.height_type, survey::HeightType::ellipsoidal);
}

TEST(ImportDji, TurnedPhotographsAreUpsideDownUntilRotatedAndAreNoted) {
  const survey::Survey plain = run(dji_inputs(), import_dji);
  ImportDjiInputs in = dji_inputs();
  in.rotate = "DJI_0024-DJI_0026, DJI_0029";
  const survey::Survey turned = run(in, import_dji);
  for (std::size_t i = 0; i < plain.frames.size(); ++i) {
    const auto id = plain.frames[i].id.value;
    const double angle = base::rad_to_deg(geometry::rotation_angle(plain.frames[i].T_world_camera.rotation.transpose() *
                                                                   turned.frames[i].T_world_camera.rotation));
    const bool asked = (id >= 24 && id <= 26) || id == 29;
    constexpr double kRounding = 1e-6;  // deg
    EXPECT_NEAR(angle, asked ? 180.0 : 0.0, kRounding) << id;
  }
  EXPECT_THAT(plain.manifest.notes,
              ::testing::Contains(AllOf(HasSubstr("6 photographs"), HasSubstr("DJI_0024"), HasSubstr("--rotate"))));
}

TEST(ImportDji, SizeIsTheRastersAndTheFocalLengthTheFilmEquivalents) {
  const survey::Survey s = run(dji_inputs(), import_dji);
  ASSERT_EQ(s.manifest.cameras.size(), 1U);
  const survey::Camera& c = s.manifest.cameras[0];
  EXPECT_EQ(c.width_px, 1600);
  EXPECT_EQ(c.height_px, 900);
  EXPECT_DOUBLE_EQ(c.fx_px, 20.0 / 36.0 * 1600.0);
  EXPECT_EQ(c.cx_px, 800.0);
}

TEST(ImportDji, GivenCameraReplacesTheirs) {
  ImportDjiInputs in = dji_inputs();
  in.camera = "RADIAL,1600,900,914.2857,800,450,0.0039,0.0146";
  const survey::Survey s = run(in, import_dji);
  EXPECT_EQ(s.manifest.cameras.at(0).fx_px, 914.2857);
  in.camera = "RADIAL,4000,2250,2285.7,2000,1125,0,0";
  EXPECT_THAT(error_of([&] { (void)run(in, import_dji); }).what(), HasSubstr("1600 x 900"));
}

TEST(ImportDji, HeightsWithoutTakeoffAreRelativeAndSaySo) {
  ImportDjiInputs in = dji_inputs();
  in.takeoff_height_m.reset();
  const survey::Survey s = run(in, import_dji);
  EXPECT_EQ(s.manifest.origin.height_type, survey::HeightType::relative_takeoff);
  EXPECT_EQ(s.manifest.origin.position.height_m, 0.0);
  EXPECT_EQ(s.source("poses")->height_type, survey::HeightType::relative_takeoff);
  // 39.80 m; the tangent plane falls away by 2 mm over 150 m.
  EXPECT_NEAR(s.frames[0].T_world_camera.translation.z(), 39.80, 0.005);
  in.common.origin = kOrigin;
  EXPECT_EQ(error_of([&] { (void)run(in, import_dji); }).code(), base::ErrorCode::invalid_argument)
      << "datum not named";
  in.common.height_type = survey::HeightType::ellipsoidal;
  EXPECT_EQ(error_of([&] { (void)run(in, import_dji); }).code(), base::ErrorCode::crs_mismatch);
}

TEST(ImportDji, Egm96IsConverted) {
  ImportDjiInputs in = dji_inputs();
  in.takeoff_datum = "egm96";
  in.takeoff_height_m = 190.0;
  const survey::Survey s = run(in, import_dji);
  // EGM96 at Duluth is some 28 to 30 m below the ellipsoid.
  EXPECT_NEAR(s.manifest.origin.position.height_m, 190.0 - 28.7, 1.0);
  EXPECT_EQ(s.manifest.origin.height_type, survey::HeightType::ellipsoidal);
}

TEST(ImportDji, RotateNamesStemsAndRanges) {
  const std::vector<std::string> stems{"DJI_0001", "DJI_0002", "DJI_0010", "a-b"};
  EXPECT_THAT(stems_named("", stems), ElementsAre(false, false, false, false));
  EXPECT_THAT(stems_named("DJI_0002", stems), ElementsAre(false, true, false, false));
  EXPECT_THAT(stems_named("DJI_0001-DJI_0002, DJI_0010", stems), ElementsAre(true, true, true, false));
  EXPECT_THAT(stems_named("a-b", stems), ElementsAre(false, false, false, true));
  EXPECT_THAT(error_of([&] { (void)stems_named("DJI_0003", stems); }).what(), HasSubstr("'DJI_0003'"));
}

// Photographs made for the test: position, attitude and what else is asked for.
std::string photo(const std::string& attributes, const std::string& more = {}, bool position = true) {
  testing::Exif exif;
  exif.ascii(testing::Exif::main, 0x010F, "DJI").ascii(testing::Exif::main, 0x0110, "TEST");
  if (position)
    exif.ascii(testing::Exif::gps, 1, "N")
        .rationals(testing::Exif::gps, 2, {{46, 1}, {30, 1}, {0, 1}})
        .ascii(testing::Exif::gps, 3, "E")
        .rationals(testing::Exif::gps, 4, {{7, 1}, {30, 1}, {0, 1}});
  exif.number(testing::Exif::photo, 0xA405, 24)
      .number(testing::Exif::photo, 0xA002, 3200)
      .number(testing::Exif::photo, 0xA003, 1800);
  return testing::jpeg(
      {exif.segment(), testing::xmp_segment("<rdf:Description xmlns:drone-dji=\"http://www.dji.com/drone-dji/1.0/\" " +
                                            attributes + " " + more + "/>")});
}

constexpr const char* kAttitude =
    "drone-dji:GimbalYawDegree=\"+0.0\" drone-dji:GimbalPitchDegree=\"-90.0\" drone-dji:GimbalRollDegree=\"+0.0\" "
    "drone-dji:FlightYawDegree=\"+77.0\" drone-dji:RelativeAltitude=\"+30.0\"";

struct MadePhotos {
  TempFolder folder;
  ImportDjiInputs in;

  explicit MadePhotos(const std::vector<std::string>& files) {
    for (std::size_t i = 0; i < files.size(); ++i)
      base::write_file(folder.path() / ("P" + std::to_string(i) + ".jpg"), files[i]);
    in.images = folder.path();
  }
};

TEST(ImportDji, RtkHeightsAreEllipsoidalWithTheirSigmas) {
  const std::string rtk =
      "drone-dji:AbsoluteAltitude=\"+412.34\" drone-dji:RtkFlag=\"50\" drone-dji:AltitudeType=\"RtkAlt\" "
      "drone-dji:RtkStdLon=\"0.012\" drone-dji:RtkStdLat=\"0.015\" drone-dji:RtkStdHgt=\"0.031\"";
  const MadePhotos photos({photo(kAttitude, rtk)});
  const survey::Survey s = run(photos.in, import_dji);
  EXPECT_EQ(s.manifest.origin.height_type, survey::HeightType::ellipsoidal);
  EXPECT_EQ(s.manifest.origin.position.height_m, 412.0);
  EXPECT_NEAR(s.frames[0].T_world_camera.translation.z(), 0.34, 1e-3);
  EXPECT_EQ(s.frames[0].sigma_xy_m, 0.015);
  EXPECT_EQ(s.frames[0].sigma_z_m, 0.031);
  EXPECT_EQ(s.source("poses")->confidence, survey::Confidence::declared);
}

TEST(ImportDji, AbsoluteAltitudeWithoutRtkIsNeverUsed) {
  for (const std::string flag : {"", "drone-dji:RtkFlag=\"0\"", "drone-dji:RtkFlag=\"15\"",
                                 "drone-dji:RtkFlag=\"50\" drone-dji:AltitudeType=\"GpsFusionAlt\""}) {
    const MadePhotos photos({photo(kAttitude, "drone-dji:AbsoluteAltitude=\"+412.34\" " + flag)});
    const survey::Survey s = run(photos.in, import_dji);
    EXPECT_EQ(s.manifest.origin.height_type, survey::HeightType::relative_takeoff) << flag;
    EXPECT_NEAR(s.frames[0].T_world_camera.translation.z(), 30.0, 1e-3) << flag;
  }
}

TEST(ImportDji, GimbalYawGoesBeforeFlightYaw) {
  const MadePhotos photos({photo(kAttitude)});
  const survey::Survey s = run(photos.in, import_dji);
  const geometry::Vec3 top = s.frames[0].T_world_camera.rotation * -geometry::Vec3::UnitY();
  EXPECT_NEAR(top.y(), 1.0, 1e-12) << "image top to the north, as the gimbal says";
  EXPECT_EQ(s.source("poses")->confidence, survey::Confidence::declared);
}

TEST(ImportDji, FlightYawIsAnAssumptionThatStrictRefuses) {
  MadePhotos photos(
      {photo("drone-dji:GimbalPitchDegree=\"-90.0\" drone-dji:FlightYawDegree=\"+90.0\" "
             "drone-dji:RelativeAltitude=\"+30.0\"")});
  const survey::Survey s = run(photos.in, import_dji);
  EXPECT_EQ(s.source("poses")->confidence, survey::Confidence::assumed);
  photos.in.common.strict = true;
  const auto error = error_of([&] { (void)run(photos.in, import_dji); });
  EXPECT_EQ(base::exit_code(error.code()), base::ExitCode::invalid_input);
  EXPECT_THAT(error.what(), HasSubstr("--strict"));
}

TEST(ImportDji, PhotographsWithoutPoseAreLeftOutWithTheReason) {
  MadePhotos photos({photo(kAttitude), photo(kAttitude, {}, false), photo("drone-dji:RelativeAltitude=\"+30.0\""),
                     photo("drone-dji:GimbalYawDegree=\"1\" drone-dji:GimbalPitchDegree=\"-90\"")});
  Outcome outcome;
  const survey::Survey s = run(photos.in, import_dji, &outcome);
  EXPECT_EQ(s.frames.size(), 1U);
  ASSERT_EQ(outcome.rejects.size(), 3U);
  EXPECT_EQ(outcome.rejects[0].reason, "no_position");
  EXPECT_EQ(outcome.rejects[0].record, "frame P1.jpg");
  EXPECT_EQ(outcome.rejects[1].reason, "no_attitude");
  EXPECT_EQ(outcome.rejects[2].reason, "no_height");
  photos.in.common.strict = true;
  EXPECT_THAT(error_of([&] { (void)run(photos.in, import_dji); }).what(), HasSubstr("P1.jpg"));
  const MadePhotos none({photo(kAttitude, {}, false)});
  EXPECT_EQ(base::exit_code(error_of([&] { (void)run(none.in, import_dji); }).code()), base::ExitCode::invalid_input);
}

TEST(ImportDji, DewarpDataGivesIntrinsicsFromTheCentreAndTurnsWithThePixels) {
  // For the 3200 px original; the file has 1600 px.
  const std::string dewarp = "drone-dji:DewarpData=\"2022-01-01;2400,2402,10,-20,0.1,-0.2,0.001,-0.002,0.05\"";
  MadePhotos photos({photo(kAttitude, dewarp), photo(kAttitude, dewarp)});
  photos.in.rotate = "P1";
  const survey::Survey s = run(photos.in, import_dji);
  ASSERT_EQ(s.manifest.cameras.size(), 2U) << "a turned image has a mirrored principal point";
  const survey::Camera &c = s.manifest.cameras[0], &turned = s.manifest.cameras[1];
  EXPECT_EQ(c.model, survey::CameraModel::brown);
  EXPECT_EQ(c.fx_px, 1200.0);
  EXPECT_EQ(c.fy_px, 1201.0);
  EXPECT_EQ(c.cx_px, 805.0);
  EXPECT_EQ(c.cy_px, 440.0);
  EXPECT_EQ(c.k1, 0.1);
  EXPECT_EQ(c.k2, -0.2);
  EXPECT_EQ(c.p1, 0.001);
  EXPECT_EQ(c.p2, -0.002);
  EXPECT_EQ(c.k3, 0.05);
  // A world point falls on the pixel turned about the image's centre.
  const geometry::Vec3 p(3, 2, 0);
  const auto a = camera::project_world(c, s.frames[0].T_world_camera, p);
  const auto b = camera::project_world(turned, s.frames[1].T_world_camera, p);
  ASSERT_TRUE(a && b);
  EXPECT_NEAR(a->x() + b->x(), 1600.0, 1e-9);
  EXPECT_NEAR(a->y() + b->y(), 900.0, 1e-9);
}

TEST(ImportDji, FolderWithoutPhotographsIsNotFound) {
  const TempFolder folder;
  ImportDjiInputs in;
  in.images = folder.path();
  EXPECT_EQ(error_of([&] { (void)run(in, import_dji); }).code(), base::ErrorCode::not_found);
}

TEST(ImportNames, FrameIdsAreTheNumbersOfTheImagesWhereTheyAreUnique) {
  const auto values = [](const std::vector<std::string>& names) {
    std::vector<std::int64_t> out;
    for (const auto id : frame_ids_for(names)) out.push_back(id.value);
    return out;
  };
  EXPECT_THAT(values({"DJI_0018.JPG", "DJI_0020.JPG"}), ElementsAre(18, 20));
  EXPECT_THAT(values({"b/DJI_0018.JPG", "a/DJI_0018.JPG"}), ElementsAre(2, 1));
  EXPECT_THAT(values({"roof.jpg", "7.jpg"}), ElementsAre(2, 1));
  EXPECT_THAT(values({"IMG_20231122334455.jpg", "x1.jpg"}), ElementsAre(1, 2));
}

TEST(ImportNames, OriginIsThreeNumbersOnTheGlobe) {
  EXPECT_EQ(parse_origin("46.8426,-91.9940,158.0"), kOrigin);
  EXPECT_EQ(parse_origin("-33.5, 151, 0").latitude_deg, -33.5);
  for (const std::string bad : {"", "46.8,-91.9", "46.8,-91.9,1,2", "46.8;-91.9;1", "a,b,c", "nan,0,0"})
    EXPECT_EQ(error_of([&] { (void)parse_origin(bad); }).code(), base::ErrorCode::invalid_argument) << bad;
  EXPECT_EQ(error_of([&] { (void)parse_origin("146.8,-91.9,158"); }).code(), base::ErrorCode::crs_mismatch);
  EXPECT_EQ(error_of([&] { (void)parse_origin("5188114,576661,158"); }).code(), base::ErrorCode::crs_mismatch);
}

// Tables of frames, made from the reconstruction.
class ImportCsv : public ::testing::Test {
 protected:
  TempFolder folder_;
  survey::Survey reference_ = run(colmap_inputs(), import_colmap);

  [[nodiscard]] ImportCsvInputs inputs(const std::string& table) const {
    base::write_file(folder_ / "frames.csv", table);
    ImportCsvInputs in;
    in.common.origin = kOrigin;
    in.common.height_type = survey::HeightType::ellipsoidal;
    in.table = folder_ / "frames.csv";
    in.images = kBeach / "images_1600";
    in.camera = "RADIAL,1600,900,914.2857142857143,800,450,0.0039291586793227425,0.014631403822475558";
    return in;
  }
  static std::string name_of(const survey::Frame& frame) { return fs::path(frame.image).filename().string(); }
  void expect_reference(const survey::Survey& s, double position, double rotation) const {
    ASSERT_EQ(s.frames.size(), reference_.frames.size());
    for (const auto& frame : s.frames) {
      const auto& T = reference_.frame(frame.id)->T_world_camera;
      EXPECT_LE((frame.T_world_camera.translation - T.translation).norm(), position) << frame.id.value;
      EXPECT_LE((frame.T_world_camera.rotation - T.rotation).cwiseAbs().maxCoeff(), rotation) << frame.id.value;
    }
  }
};

constexpr double kTextRounding = 1e-9;  // m and direction cosines: shortest round-trip text loses nothing

TEST_F(ImportCsv, LocalPositionsAndQuaternionsInAnyColumnOrder) {
  std::string table = "# made for a test\nqz,image,qw,z,qx,y,qy,x,note\n";
  for (const auto& frame : reference_.frames) {
    const auto q = geometry::quaternion(frame.T_world_camera.rotation);
    const auto& p = frame.T_world_camera.translation;
    for (const std::string& cell :
         {base::to_text(q.qz), name_of(frame), base::to_text(q.qw), base::to_text(p.z()), base::to_text(q.qx),
          base::to_text(p.y()), base::to_text(q.qy), base::to_text(p.x())})
      table += cell + ",";
    table += "\"a, note\"\n";
  }
  ImportCsvInputs in = inputs(table);
  in.pose = "camera-to-world";
  expect_reference(run(in, import_csv), kTextRounding, kTextRounding);
  in.pose.clear();
  EXPECT_EQ(error_of([&] { (void)run(in, import_csv); }).code(), base::ErrorCode::invalid_argument) << "not declared";
}

TEST_F(ImportCsv, WorldToCameraIsInverted) {
  std::string table = "image,x_m,y_m,z_m,qw,qx,qy,qz\n";
  for (const auto& frame : reference_.frames) {
    const auto inverse = frame.T_world_camera.inverse();
    const auto q = geometry::quaternion(inverse.rotation);
    table += name_of(frame);
    for (const double v :
         {inverse.translation.x(), inverse.translation.y(), inverse.translation.z(), q.qw, q.qx, q.qy, q.qz})
      table += "," + base::to_text(v);
    table += "\n";
  }
  ImportCsvInputs in = inputs(table);
  in.pose = "world-to-camera";
  expect_reference(run(in, import_csv), kTextRounding, kTextRounding);
}

TEST_F(ImportCsv, GeodeticPositionsAndGimbalAngles) {
  const geodesy::LocalFrame local(kOrigin);
  const auto g = local.to_geodetic({10, 20, 30});
  const std::string table = "image,lat,lon,height,yaw,pitch,roll,sigma_xy_m\nDJI_0018.JPG," +
                            base::to_text(g.latitude_deg) + "," + base::to_text(g.longitude_deg) + "," +
                            base::to_text(g.height_m) + ",90,-90,0,0.5\n";
  ImportCsvInputs in = inputs(table);
  in.angles = "gimbal";
  const survey::Survey s = run(in, import_csv);
  constexpr double kGeodesy = 1e-6;  // m
  EXPECT_LT((s.frames[0].T_world_camera.translation - geometry::Vec3(10, 20, 30)).norm(), kGeodesy);
  EXPECT_NEAR((s.frames[0].T_world_camera.rotation * -geometry::Vec3::UnitY()).x(), 1.0, 1e-12)
      << "image top to the east";
  EXPECT_EQ(s.frames[0].sigma_xy_m, 0.5);
  in.common.height_type.reset();
  EXPECT_EQ(error_of([&] { (void)run(in, import_csv); }).code(), base::ErrorCode::invalid_argument)
      << "datum not named";
}

TEST_F(ImportCsv, TablesWithoutNamesAreRefusedWithAListOfWhatIsNeeded) {
  ImportCsvInputs in = inputs("DJI_0018.JPG,1,2,3,1,0,0,0.5\n");
  in.pose = "camera-to-world";
  const auto error = error_of([&] { (void)run(in, import_csv); });
  EXPECT_EQ(base::exit_code(error.code()), base::ExitCode::invalid_input);
  EXPECT_THAT(error.what(), AllOf(HasSubstr("qw,qx,qy,qz"), HasSubstr("latitude_deg"), HasSubstr("image")));
}

TEST_F(ImportCsv, BadRowsAreRefusedWithTheirLine) {
  const auto refuse = [&](const std::string& row) {
    ImportCsvInputs in = inputs("image,x_m,y_m,z_m,qw,qx,qy,qz\n" + row + "\n");
    in.pose = "camera-to-world";
    const auto error = error_of([&] { (void)run(in, import_csv); });
    EXPECT_EQ(base::exit_code(error.code()), base::ExitCode::invalid_input) << row;
    return std::string(error.what());
  };
  EXPECT_THAT(refuse("DJI_0018.JPG,nan,0,0,1,0,0,0"), HasSubstr("line 2, column x_m"));
  EXPECT_THAT(refuse("DJI_0018.JPG,0,0,0,0,0,0,0"), HasSubstr("|q| = 0"));
  EXPECT_THAT(refuse("DJI_0099.JPG,0,0,0,1,0,0,0"), HasSubstr("DJI_0099.JPG"));
  EXPECT_THAT(refuse(",0,0,0,1,0,0,0"), HasSubstr("value is missing"));
}

TEST_F(ImportCsv, LatitudeOutOfRangeIsRefusedWithItsLine) {
  ImportCsvInputs in = inputs(
      "image,latitude_deg,longitude_deg,height_m,yaw_deg,pitch_deg,roll_deg\nDJI_0018.JPG,5188114,7,1,0,-90,0\n");
  in.angles = "gimbal";
  const auto error = error_of([&] { (void)run(in, import_csv); });
  EXPECT_EQ(base::exit_code(error.code()), base::ExitCode::invalid_input);
  EXPECT_THAT(error.what(),
              AllOf(HasSubstr("line 2, column latitude_deg"), HasSubstr("-90 to 90"), HasSubstr("projected")));
}

TEST(ImportFinish, ImagesAreCopiedWhereAsked) {
  const TempFolder folder;
  const fs::path out = folder / "survey";
  fs::create_directories(out);
  ImportColmapInputs in = colmap_inputs();
  in.common.survey_folder = out;
  in.common.copy_images = true;
  base::RunContext ctx;
  (void)import_colmap(in, out, ctx);
  const survey::Survey s = io::read_survey(out);
  EXPECT_EQ(s.frames[0].image, "images/DJI_0018.JPG");
  EXPECT_EQ(base::read_file(out / s.frames[0].image), base::read_file(kBeach / "images_1600/DJI_0018.JPG"));
}

}  // namespace
}  // namespace cairn::pipeline
