#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "io/json.hpp"
#include "io/survey_folder.hpp"
#include "support/data.hpp"
#include "support/run_program.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::testing::cairn;
using cairn::testing::TempFolder;
using ::testing::AllOf;
using ::testing::HasSubstr;

const fs::path kBeach = cairn::testing::sample("brighton_beach");

class ImportCommand : public ::testing::Test {
 protected:
  TempFolder folder_;
  std::string out_ = (folder_ / "survey").string();

  [[nodiscard]] std::vector<std::string> colmap(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"import",
                                       "colmap",
                                       (kBeach / "colmap_enu").string(),
                                       "--images",
                                       (kBeach / "images_1600").string(),
                                       "--origin",
                                       "46.8426,-91.9940,158.0",
                                       "--height-type",
                                       "ellipsoidal",
                                       "--scale-images",
                                       "0.4",
                                       "-o",
                                       out_};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  [[nodiscard]] std::vector<std::string> dji(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"import", "dji", (kBeach / "images_1600").string(), "-o", out_};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  // Nothing half-written stays behind: neither the survey nor a temporary beside it.
  void expect_nothing_left() const {
    EXPECT_TRUE(fs::is_empty(folder_.path())) << *fs::directory_iterator(folder_.path());
  }
};

TEST_F(ImportCommand, ColmapWithEverythingAttached) {
  const auto result =
      cairn(colmap({"--detections", (kBeach / "detections.csv").string(), "--cloud", (kBeach / "model.las").string(),
                    "--similarity", (kBeach / "enu_frame.json").string(), "--json"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = cairn::io::parse_json(result.out, "stdout");
  EXPECT_EQ(summary.at("frames").as_integer(), 18);
  EXPECT_EQ(summary.at("detections").as_integer(), 314);
  EXPECT_EQ(summary.at("tie_observations").as_integer(), 19804);
  const auto survey = cairn::io::read_survey(out_);
  EXPECT_EQ(survey.frames.size(), 18U);
  EXPECT_TRUE(fs::exists(cairn::io::resolve_reference(survey.frames[0].image, out_)));
  EXPECT_TRUE(fs::exists(cairn::io::resolve_reference(survey.source("cloud")->path, out_)));
  const auto run = cairn::io::read_json(fs::path(out_) / "run.json");
  EXPECT_EQ(run.at("command").as_string(), "import");
}

TEST_F(ImportCommand, OpensfmReconstructionWithItsTracks) {
  const auto berlin = cairn::testing::test_data("opensfm_berlin");
  const auto result = cairn({"import", "opensfm", berlin.string(), "-o", out_, "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("datum is unknown"));
  const auto summary = cairn::io::parse_json(result.out, "stdout");
  EXPECT_EQ(summary.at("frames").as_integer(), 3);
  EXPECT_EQ(summary.at("tie_points").as_integer(), 1430);
  EXPECT_EQ(summary.at("tie_observations").as_integer(), 3082);
  const auto survey = cairn::io::read_survey(out_);
  EXPECT_DOUBLE_EQ(survey.manifest.origin.position.longitude_deg, 13.400376851851851);
  // What check makes of it: track pixels against the points, with no pose convention to blame.
  const auto check = cairn({"check", out_, "--json"});
  // Photographs of a facade from the street: no camera is above the ground that its tie points make, and check says so.
  EXPECT_EQ(check.exit_code, 4) << check.out;
  EXPECT_THAT(check.out, HasSubstr("axis_misses_ground"));
  const auto ties = cairn::io::parse_json(check.out, "stdout").at("evidence").at("tie_points_reprojection");
  constexpr double kMedianPx = 1.0;  // measured 0.80 px of 3264
  EXPECT_LT(ties.at("median_px").as_real(), kMedianPx);
}

TEST_F(ImportCommand, OpensfmWithoutItsImagesOrAReferenceIsRefused) {
  const auto berlin = cairn::testing::test_data("opensfm_berlin");
  const auto missing =
      cairn({"import", "opensfm", berlin.string(), "--images", (kBeach / "images_1600").string(), "-o", out_});
  EXPECT_EQ(missing.exit_code, 4);
  EXPECT_THAT(missing.err, HasSubstr("3 of 3 images missing"));
  const auto nothing = cairn({"import", "opensfm", kBeach.string(), "-o", out_});
  EXPECT_EQ(nothing.exit_code, 4);
  EXPECT_THAT(nothing.err, HasSubstr("no reconstruction"));
  expect_nothing_left();
}

TEST_F(ImportCommand, SameBytesForAnyThreadCount) {
  ASSERT_EQ(cairn(colmap({"--threads", "1"})).exit_code, 0);
  std::vector<std::string> one;
  for (const auto* name : {"survey.json", "frames.csv", "tie_observations.csv"})
    one.push_back(cairn::base::read_file(fs::path(out_) / name));
  ASSERT_EQ(cairn(colmap({"--threads", "4", "--overwrite"})).exit_code, 0);
  std::size_t i = 0;
  for (const auto* name : {"survey.json", "frames.csv", "tie_observations.csv"})
    EXPECT_EQ(cairn::base::read_file(fs::path(out_) / name), one[i++]) << name;
}

TEST_F(ImportCommand, DjiWithTakeoffHeightAndTurnedPhotographs) {
  const auto result =
      cairn(dji({"--takeoff-height", "158.5", "--takeoff-datum", "ellipsoidal", "--rotate", "DJI_0024-DJI_0029"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("Windows Photo Viewer"));
  EXPECT_THAT(result.out, HasSubstr("18 frames"));
  const auto survey = cairn::io::read_survey(out_);
  EXPECT_EQ(survey.manifest.origin.position.height_m, 158.5);
  EXPECT_EQ(survey.manifest.origin.height_type, cairn::survey::HeightType::ellipsoidal);
}

TEST_F(ImportCommand, DjiPhotographWithoutPoseEndsWithItemFailures) {
  const fs::path images = folder_ / "images";
  fs::create_directory(images);
  fs::copy_file(kBeach / "images_1600/DJI_0018.JPG", images / "DJI_0018.JPG");
  const std::string photo = cairn::base::read_file(kBeach / "images_1600/DJI_0019.JPG");
  // The same picture without its metadata segments.
  cairn::base::write_file(images / "DJI_0019.JPG", "\xFF\xD8" + photo.substr(photo.find("\xFF\xDB")));
  const auto result = cairn({"import", "dji", images.string(), "-o", out_});
  EXPECT_EQ(result.exit_code, 3) << result.err;
  EXPECT_THAT(result.err, AllOf(HasSubstr("DJI_0019.JPG"), HasSubstr("no GPS position")));
  const auto run = cairn::io::read_json(fs::path(out_) / "run.json");
  EXPECT_EQ(run.at("rejects_by_reason").at("no_position").as_integer(), 1);
  EXPECT_EQ(cairn({"import", "dji", images.string(), "-o", out_ + "2", "--strict"}).exit_code, 4);
  EXPECT_FALSE(fs::exists(out_ + "2"));
}

TEST_F(ImportCommand, CsvTable) {
  cairn::base::write_file(folder_ / "frames.csv",
                          "image,x_m,y_m,z_m,qw,qx,qy,qz\nDJI_0018.JPG,1,2,40,0,1,0,0\nDJI_0019.JPG,5,2,40,0,1,0,0\n");
  const auto result =
      cairn({"import", "csv", (folder_ / "frames.csv").string(), "--images", (kBeach / "images_1600").string(),
             "--camera", "PINHOLE,1600,900,914,914,800,450", "--pose", "camera-to-world", "--origin",
             "-46.8426,-91.9940,158.0", "--height-type", "ellipsoidal", "-o", out_});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(cairn::io::read_survey(out_).manifest.origin.position.latitude_deg, -46.8426);
}

TEST_F(ImportCommand, ExistingOutputIsRefusedAndReplacedWhenTold) {
  ASSERT_EQ(cairn(colmap()).exit_code, 0);
  const auto again = cairn(colmap());
  EXPECT_EQ(again.exit_code, 7);
  EXPECT_THAT(again.err, HasSubstr("--overwrite"));
  EXPECT_EQ(cairn(colmap({"--overwrite"})).exit_code, 0);
}

TEST_F(ImportCommand, LatitudeOutOfRangeIsACrsError) {
  auto arguments = colmap();
  arguments[6] = "146.8426,-91.9940,158.0";
  const auto result = cairn(arguments);
  EXPECT_EQ(result.exit_code, 6);
  EXPECT_THAT(result.err, AllOf(HasSubstr("latitude out of range"), HasSubstr("146.8426"), HasSubstr("-90 to 90")));
  expect_nothing_left();
}

TEST_F(ImportCommand, MissingImagesAreNamed) {
  auto arguments = colmap();
  const TempFolder empty;
  arguments[4] = empty.path().string();
  const auto result = cairn(arguments);
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, AllOf(HasSubstr("18 of 18 images missing"), HasSubstr("DJI_0018.JPG")));
  expect_nothing_left();
}

TEST_F(ImportCommand, CutImageIsRefused) {
  const TempFolder images;
  const std::string photo = cairn::base::read_file(kBeach / "images_1600/DJI_0018.JPG");
  cairn::base::write_file(images / "DJI_0018.JPG", photo.substr(0, photo.size() / 2));
  const auto result = cairn({"import", "dji", images.path().string(), "-o", out_});
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, HasSubstr("DJI_0018.JPG"));
  expect_nothing_left();
}

TEST_F(ImportCommand, DetectionOfAnUnknownFrameIsRefused) {
  const TempFolder tables;
  cairn::base::write_file(tables / "d.csv",
                          "image,class,xmin_px,ymin_px,xmax_px,ymax_px,score\nDJI_0099.JPG,car,1,2,3,4,0.5\n");
  const auto result = cairn(colmap({"--detections", (tables / "d.csv").string(), "--json"}));
  EXPECT_EQ(result.exit_code, 4);
  const auto error = cairn::io::parse_json(result.out, "stdout").at("error");
  EXPECT_THAT(error.at("file").as_string(), HasSubstr("d.csv"));
  EXPECT_EQ(error.at("record").as_string(), "line 2, column image");
  EXPECT_EQ(error.at("found").as_string(), "'DJI_0099.JPG'");
  EXPECT_NE(error.find("hint"), nullptr);
  expect_nothing_left();
}

TEST_F(ImportCommand, CloudWithoutCrsIsRefusedUnlessOneIsGiven) {
  // The GeoTIFF record's identifier is spoilt, so that nothing declares the CRS.
  std::string las = cairn::base::read_file(kBeach / "model.las");
  for (auto at = las.find("LASF_Projection"); at != std::string::npos && at < 429; at = las.find("LASF_Projection", at))
    las.replace(at, 15, "NOT_A_PROJECTIO");
  const TempFolder clouds;
  cairn::base::write_file(clouds / "model.las", las);
  const std::string cloud = (clouds / "model.las").string();
  const auto result = cairn(colmap({"--cloud", cloud}));
  EXPECT_EQ(result.exit_code, 6);
  EXPECT_THAT(result.err, HasSubstr("--cloud-crs"));
  expect_nothing_left();
  EXPECT_EQ(cairn(colmap({"--cloud", cloud, "--cloud-crs", "EPSG:32615"})).exit_code, 0);
  EXPECT_EQ(cairn::io::read_survey(out_).source("cloud")->crs, "EPSG:32615");
}

TEST_F(ImportCommand, UsageErrors) {
  EXPECT_EQ(cairn({"import"}).exit_code, 2);
  EXPECT_EQ(cairn({"import", "metashape", "x", "-o", out_}).exit_code, 2);
  EXPECT_EQ(cairn({"import", "colmap", (kBeach / "colmap_enu").string(), "-o", out_}).exit_code, 2) << "no images";
  auto arguments = colmap();
  arguments[6] = "46.8426";
  EXPECT_EQ(cairn(arguments).exit_code, 2);
  EXPECT_EQ(cairn(dji({"--rotate", "DJI_0099"})).exit_code, 2);
  EXPECT_EQ(cairn({"import", "dji", "/nonexistent", "-o", out_}).exit_code, 4);
  expect_nothing_left();
}

TEST_F(ImportCommand, FolderThatCannotBeWrittenIsReported) {
  auto arguments = colmap();
  arguments.back() = "/proc/cairn/survey";
  EXPECT_EQ(cairn(arguments).exit_code, 5);
}

}  // namespace
