// Bad input of every kind: `check` names the file, the record, what was found, what is allowed, the remedy.
#include <fstream>

#include "check_run.hpp"
#include "support/data.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::geometry::RigidTransform;
using cairn::testing::check;
using cairn::testing::CheckRun;
using cairn::testing::replace_cell;
using cairn::testing::TempFolder;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

class CheckBadInput : public ::testing::Test {
 protected:
  TempFolder folder_;
  fs::path survey_ = folder_ / "survey";

  void write(const cairn::survey::Survey& survey) { cairn::testing::write_check_survey(survey, survey_); }
  void write_small() { write(cairn::testing::check_small_survey()); }

  // One finding of `code` at error level whose parts hold these texts, and exit code 4.
  CheckRun expect(const std::string& code, const std::string& file, const std::string& record, const std::string& found,
                  const std::string& allowed, const std::string& hint) {
    auto run = check(survey_);
    EXPECT_EQ(run.exit_code, 4) << run.json.dump();
    EXPECT_FALSE(run.ok());
    const auto findings = run.findings(code);
    EXPECT_THAT(findings, SizeIs(1)) << run.json.dump();
    if (findings.size() != 1) return run;
    const auto& f = findings[0];
    EXPECT_EQ(f.at("severity").as_string(), "error");
    EXPECT_THAT(f.at("file").as_string(), HasSubstr(file));
    EXPECT_THAT(f.at("record").as_string(), HasSubstr(record));
    EXPECT_THAT(f.at("message").as_string(), HasSubstr(found));
    EXPECT_THAT(f.at("message").as_string(), HasSubstr(allowed));
    EXPECT_THAT(f.at("hint").as_string(), HasSubstr(hint));
    EXPECT_THAT(f.at("hint").as_string(), Not(::testing::IsEmpty()));
    return run;
  }
};

constexpr std::size_t kImage = 3, kX = 4, kQw = 7;  // columns of frames.csv

TEST_F(CheckBadInput, MissingImage) {
  write_small();
  replace_cell(survey_ / "frames.csv", 1, kImage, "photos/gone.jpg");
  expect("image_missing", "gone.jpg", "line 3", "no file", "JPEG or PNG", "Put the image back");
}

TEST_F(CheckBadInput, UnreadableImage) {
  write_small();
  cairn::testing::write_text(folder_ / "text.jpg", "this is no image");
  replace_cell(survey_ / "frames.csv", 0, kImage, (folder_ / "text.jpg").string());
  auto run = check(survey_);
  ASSERT_THAT(run.findings("image_unreadable"), SizeIs(1));
  EXPECT_THAT(run.findings("image_unreadable")[0].at("message").as_string(),
              AllOf(HasSubstr("not an image"), HasSubstr("JPEG or PNG")));
  EXPECT_EQ(run.exit_code, 4);
}

TEST_F(CheckBadInput, TruncatedImage) {
  write_small();
  const auto whole = cairn::testing::read_text(cairn::testing::brighton_image(18));
  cairn::testing::write_text(folder_ / "cut.jpg", whole.substr(0, whole.size() / 2));
  replace_cell(survey_ / "frames.csv", 0, kImage, (folder_ / "cut.jpg").string());
  expect("image_unreadable", "cut.jpg", "line 2", "truncated", "", "Copy the image again");
}

TEST_F(CheckBadInput, ImageOfAnotherSize) {
  auto survey = cairn::testing::check_small_survey();
  survey.manifest.cameras[0].width_px = 4000;
  survey.manifest.cameras[0].height_px = 2250;
  write(survey);
  const auto run = check(survey_);
  EXPECT_EQ(run.exit_code, 4);
  ASSERT_THAT(run.findings("image_size_mismatch"), SizeIs(4));
  EXPECT_THAT(run.findings("image_size_mismatch")[0].at("message").as_string(),
              AllOf(HasSubstr("1600 x 900"), HasSubstr("4000 x 2250")));
  EXPECT_THAT(run.findings("image_size_mismatch")[0].at("hint").as_string(), HasSubstr("--scale-images 0.4"));
}

TEST_F(CheckBadInput, FrameWithoutPose) {
  write_small();
  for (std::size_t column = kX; column < kX + 7; ++column) replace_cell(survey_ / "frames.csv", 2, column, "");
  expect("frame_without_pose", "frames.csv", "line 4", "an empty cell", "T_world_camera", "Give the frame its pose");
}

TEST_F(CheckBadInput, NanPose) {
  write_small();
  replace_cell(survey_ / "frames.csv", 2, kX + 1, "nan");
  expect("pose_not_finite", "frames.csv", "line 4", "nan", "a finite number", "Import the poses again");
}

TEST_F(CheckBadInput, QuaternionNotOfUnitLength) {
  write_small();
  replace_cell(survey_ / "frames.csv", 0, kQw, "0.9");
  expect("quaternion_not_unit", "frames.csv", "line 2", "|q| = ", "1 within 0.001", "order of the columns");
}

TEST_F(CheckBadInput, DetectionOfAnUnknownFrame) {
  write_small();
  replace_cell(survey_ / "detections.csv", 1, 1, "99");
  expect("unknown_frame", "detections.csv", "line 3", "99", "one of the 4 frames", "Remove the row");
}

TEST_F(CheckBadInput, BoxOutsideTheImage) {
  write_small();
  replace_cell(survey_ / "detections.csv", 2, 6, "1700");
  expect("box_outside_image", "detections.csv", "line 4", "1700.0", "0,0,1600,900", "--scale-images");
}

TEST_F(CheckBadInput, LatitudeOutOfRange) {
  write_small();
  auto json = cairn::io::read_json(survey_ / "survey.json");
  auto origin = json.at("origin");
  origin.set("latitude_deg", 146.8);
  json.set("origin", origin);
  cairn::testing::write_text(survey_ / "survey.json", json.dump());
  expect("origin_out_of_range", "survey.json", "origin", "146.8", "90", "");
}

TEST_F(CheckBadInput, AllFaultsAreListedNotOnlyTheFirst) {
  write_small();
  replace_cell(survey_ / "frames.csv", 0, kImage, "gone.jpg");
  replace_cell(survey_ / "frames.csv", 1, kX, "inf");
  replace_cell(survey_ / "frames.csv", 2, 2, "7");
  replace_cell(survey_ / "detections.csv", 0, 3, "1.5");
  replace_cell(survey_ / "detections.csv", 1, 0, "1x");
  replace_cell(survey_ / "detections.csv", 2, 1, "77");
  const auto run = check(survey_);
  EXPECT_EQ(run.exit_code, 4);
  for (const char* code :
       {"image_missing", "pose_not_finite", "unknown_camera", "score_out_of_range", "cell_invalid", "unknown_frame"})
    EXPECT_THAT(run.findings(code), SizeIs(1)) << code;
}

TEST_F(CheckBadInput, NoSurveyThere) {
  const auto result = cairn::testing::cairn({"check", (folder_ / "nowhere").string(), "--json"});
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err + result.out, HasSubstr("cairn import"));
}

// Conventions, proved against the tie points of the real survey.
struct Convention {
  const char* code;
  RigidTransform (*spoil)(const RigidTransform&);
};

class CheckConvention : public CheckBadInput, public ::testing::WithParamInterface<Convention> {};

TEST_P(CheckConvention, IsNamed) {
  auto survey = cairn::testing::check_small_survey();
  for (auto& frame : survey.frames) frame.T_world_camera = GetParam().spoil(frame.T_world_camera);
  write(survey);
  expect(GetParam().code, "frames.csv", "all 4 frames", "median reprojection error", "at most 5.0 px", "import again");
}

INSTANTIATE_TEST_SUITE_P(
    Poses, CheckConvention,
    ::testing::Values(
        Convention{"quaternion_order_xyzw",
                   [](const RigidTransform& T) {
                     const auto q = cairn::geometry::quaternion(T.rotation);
                     return RigidTransform{cairn::geometry::rotation_matrix({q.qx, q.qy, q.qz, q.qw}), T.translation};
                   }},
        Convention{"pose_inverted", [](const RigidTransform& T) { return T.inverse(); }},
        Convention{"camera_axes_opengl",
                   [](const RigidTransform& T) {
                     cairn::geometry::Mat3 flip = cairn::geometry::Mat3::Identity();
                     flip.diagonal() << 1, -1, -1;
                     return RigidTransform{T.rotation * flip, T.translation};
                   }}),
    [](const auto& param) { return std::string(param.param.code); });

// Clouds: the sample's, thinned and spoilt.
class CheckBadCloud : public CheckBadInput {
 protected:
  fs::path cloud_ = folder_ / "cloud.las";

  template <typename Change>
  void write_with_cloud(const std::string& crs, Change change) {
    const auto all = cairn::testing::brighton_beach_cloud_utm();
    cairn::geometry::PointCloud few;
    for (std::size_t i = 0; i < all.size(); i += 20) {
      few.positions.push_back(change(all.positions[i]));
      few.colours.push_back(all.colours[i]);
    }
    cairn::io::LasWriteOptions options;
    options.minor_version = 2;
    options.crs = crs;
    cairn::io::write_las(cloud_, few, options);
    auto survey = cairn::testing::check_small_survey();
    survey.manifest.sources.push_back(cairn::testing::cloud_source(cloud_));
    write(survey);
  }
  static cairn::geometry::Vec3 same(const cairn::geometry::Vec3& p) { return p; }
};

constexpr double kFoot = 0.3048;

TEST_F(CheckBadCloud, SoundCloudHasNoError) {
  write_with_cloud("EPSG:32615", same);
  const auto run = check(survey_);
  EXPECT_EQ(run.exit_code, 0) << run.json.dump();
}

TEST_F(CheckBadCloud, InFeet) {
  write_with_cloud("EPSG:32615", [](const auto& p) { return cairn::geometry::Vec3(p / kFoot); });
  expect("cloud_in_feet", "cloud.las", "coordinates", "EPSG:32615", "at most 500 m", "metres");
}

TEST_F(CheckBadCloud, HeightsInFeet) {
  write_with_cloud("EPSG:32615", [](const auto& p) { return cairn::geometry::Vec3(p.x(), p.y(), p.z() / kFoot); });
  expect("cloud_heights_in_feet", "cloud.las", "z", "m above the tie points", "within 30 m", "convert z to metres");
}

TEST_F(CheckBadCloud, WithoutCrs) {
  write_with_cloud("", same);
  expect("cloud_no_crs", "cloud.las", "coordinate reference system", "none", "EPSG:n", "--cloud-crs");
}

TEST_F(CheckBadCloud, WrongCrs) {
  write_with_cloud("EPSG:32616", same);
  expect("cloud_wrong_crs", "cloud.las", "coordinate reference system", "EPSG:32616", "at most 500 m",
         "--cloud-crs EPSG:32615");
}

TEST_F(CheckBadCloud, OfAnotherPlace) {
  write_with_cloud("EPSG:32615",
                   [](const auto& p) { return cairn::geometry::Vec3(p + cairn::geometry::Vec3(30e3, 0, 0)); });
  expect("cloud_far_from_survey", "cloud.las", "coordinates", "km from the cameras", "at most 500 m", "belongs to");
}

TEST_F(CheckBadCloud, Empty) {
  cairn::io::LasWriteOptions options;
  options.crs = "EPSG:32615";
  options.minor_version = 2;
  cairn::io::write_las(cloud_, {}, options);
  auto survey = cairn::testing::check_small_survey();
  survey.manifest.sources.push_back(cairn::testing::cloud_source(cloud_));
  write(survey);
  expect("cloud_empty", "cloud.las", "points", "0 points", "at least 1", "Export the cloud again");
}

TEST_F(CheckBadCloud, Truncated) {
  write_with_cloud("EPSG:32615", same);
  fs::resize_file(cloud_, fs::file_size(cloud_) - 1000);
  expect("cloud_unreadable", "cloud.las", "byte", "points", "at most", "truncated");
}

TEST_F(CheckBadCloud, StatesFeetBesideACrsInMetres) {
  // ProjLinearUnitsGeoKey 3076, one value: 9001 (metre) becomes 9003 (US survey foot).
  auto bytes = cairn::testing::read_text(cairn::testing::sample("brighton_beach/model.las"));
  const auto at = bytes.find(std::string("\x04\x0c\0\0\x01\0\x29\x23", 8));
  ASSERT_NE(at, std::string::npos);
  bytes[at + 6] = '\x2b';
  cairn::testing::write_text(cloud_, bytes);
  auto survey = cairn::testing::check_small_survey();
  survey.manifest.sources.push_back(cairn::testing::cloud_source(cloud_));
  write(survey);
  expect("cloud_units_contradict", "cloud.las", "horizontal unit", "0.3048", "1 m a unit", "--cloud-crs");
}

TEST_F(CheckBadCloud, Missing) {
  write_with_cloud("EPSG:32615", same);
  fs::remove(cloud_);
  expect("cloud_missing", "cloud.las", "source 'cloud'", "no file", "LAS", "--cloud");
}

}  // namespace
