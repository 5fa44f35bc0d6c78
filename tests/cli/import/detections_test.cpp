// Boxes of foreign formats attached to a survey.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "io/survey_folder.hpp"
#include "support/data.hpp"
#include "support/run_program.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::testing::cairn;
using ::testing::HasSubstr;

const fs::path kBeach = cairn::testing::sample("brighton_beach");

class ImportDetections : public ::testing::Test {
 protected:
  cairn::testing::TempFolder folder_;
  fs::path out_ = folder_ / "survey";

  fs::path file(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_ / name).parent_path());
    cairn::base::write_file(folder_ / name, text);
    return folder_ / name;
  }
  [[nodiscard]] cairn::testing::ProgramResult import(const fs::path& boxes, std::vector<std::string> more = {}) const {
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
                                       "--detections-scale",
                                       "1",
                                       "--overwrite",
                                       "--detections",
                                       boxes.string(),
                                       "-o",
                                       out_.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return cairn(arguments);
  }
  void expect_one(const cairn::geometry::PixelBox& box, const std::string& object_class, std::int64_t frame) const {
    constexpr double kRounding = 1e-9;  // px
    const auto survey = cairn::io::read_survey(out_);
    ASSERT_EQ(survey.detections.size(), 1U);
    const auto& d = survey.detections[0];
    EXPECT_EQ(d.object_class, object_class);
    EXPECT_EQ(d.frame.value, frame);
    EXPECT_NEAR(d.box.xmin, box.xmin, kRounding);
    EXPECT_NEAR(d.box.ymin, box.ymin, kRounding);
    EXPECT_NEAR(d.box.xmax, box.xmax, kRounding);
    EXPECT_NEAR(d.box.ymax, box.ymax, kRounding);
  }
};

TEST_F(ImportDetections, Coco) {
  const auto boxes =
      file("gt.json", R"({"images": [{"id": 5, "file_name": "DJI_0020.JPG", "width": 1600, "height": 900}],
    "categories": [{"id": 3, "name": "boulder"}], "annotations": [{"image_id": 5, "category_id": 3, "bbox": [10, 20, 30, 40]},
    {"image_id": 5, "category_id": 3, "bbox": [1, 2, 3, 4], "iscrowd": 1}]})");
  const auto result = import(boxes);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  expect_one({10, 20, 40, 60}, "boulder", 20);
  EXPECT_THAT(result.err, HasSubstr("1 boxes that gt.json marks as not counting"));
}

TEST_F(ImportDetections, YoloTakesTheSizesFromTheSurveysImages) {
  file("labels/DJI_0019.txt", "0 0.5 0.5 0.25 0.5\n");
  const auto result = import(folder_ / "labels", {"--detections-names", file("names.txt", "boulder\ntree\n").string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto survey = cairn::io::read_survey(out_);
  const auto& camera = survey.manifest.cameras[0];
  const double w = static_cast<double>(camera.width_px), h = static_cast<double>(camera.height_px);
  expect_one({0.375 * w, 0.25 * h, 0.625 * w, 0.75 * h}, "boulder", 19);
}

TEST_F(ImportDetections, PascalVocPixelsCountFromOne) {
  file("voc/DJI_0018.xml",
       "<annotation><filename>DJI_0018.JPG</filename><object><name>car</name><bndbox><xmin>11</xmin>"
       "<ymin>21</ymin><xmax>40</xmax><ymax>60</ymax></bndbox></object></annotation>");
  ASSERT_EQ(import(folder_ / "voc").exit_code, 0);
  expect_one({10, 20, 40, 60}, "car", 18);
  EXPECT_THAT(cairn::io::read_survey(out_).source("detections")->convention, HasSubstr("counted from 1"));
}

TEST_F(ImportDetections, MotFramesAreTheSurveysInOrder) {
  ASSERT_EQ(import(file("det.txt", "2,-1,11,21,30,40,0.5,-1,-1,-1\n")).exit_code, 0);
  const auto survey = cairn::io::read_survey(out_);
  expect_one({10, 20, 40, 60}, "object", survey.frames[1].id.value);
}

TEST_F(ImportDetections, WhatDoesNotFitIsRefused) {
  const auto refused = [&](const fs::path& boxes, const std::string& says) {
    const auto result = import(boxes);
    EXPECT_EQ(result.exit_code, 4) << says;
    EXPECT_THAT(result.err, HasSubstr(says));
  };
  refused(file("a.txt", "99,-1,11,21,30,40,0.5\n"), "frame 99");
  refused(file("b.txt", "1,-1,11,21,-30,40,0.5\n"), "ends before it begins");
  refused(file("c.txt", "1,-1,11,nan,30,40,0.5\n"), "not finite");
  refused(file("d.txt", "1,-1,11,21,30,40,55\n"), "score out of range");
  refused(file("e.json", R"({"images": [{"id": 5, "file_name": "none.JPG"}], "categories": [{"id": 3, "name": "x"}],
    "annotations": [{"image_id": 5, "category_id": 3, "bbox": [10, 20, 30, 40]}]})"),
          "'none.JPG'");
  refused(file("f.txt", "what\n"), "not recognised");
  EXPECT_FALSE(fs::exists(out_));
}

}  // namespace
