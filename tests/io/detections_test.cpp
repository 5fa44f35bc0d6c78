#include "io/detections.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "support/data.hpp"

namespace {

namespace fs = std::filesystem;
using namespace cairn;
using cairn::testing::TempFolder;
using geometry::PixelBox;
using io::BoxFile;
using io::BoxFormat;
using io::read_boxes;
using ::testing::HasSubstr;

class Boxes : public ::testing::Test {
 protected:
  TempFolder folder_;

  fs::path file(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_ / name).parent_path());
    base::write_file(folder_ / name, text);
    return folder_ / name;
  }
  // A PNG header of this size and the end chunk: what a size is read from.
  fs::path image(const std::string& name, int width, int height) const {
    std::string png("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16);
    for (const int value : {width, height})
      for (int shift = 24; shift >= 0; shift -= 8) png += static_cast<char>((value >> shift) & 255);
    png += std::string("\x08\x02\0\0\0\0\0\0\0", 9);
    png += std::string("\0\0\0\0IEND\xae\x42\x60\x82", 12);
    return file(name, png);
  }
  static std::string refusal(const fs::path& path, BoxFormat format, const io::ReadBoxesOptions& options = {}) {
    try {
      static_cast<void>(read_boxes(path, format, options));
    } catch (const base::Error& e) {
      return e.what();
    }
    return "accepted";
  }
};

void expect_box(const io::ImageBox& box, const PixelBox& expected) {
  constexpr double kRounding = 1e-9;  // px
  EXPECT_NEAR(box.box.xmin, expected.xmin, kRounding);
  EXPECT_NEAR(box.box.ymin, expected.ymin, kRounding);
  EXPECT_NEAR(box.box.xmax, expected.xmax, kRounding);
  EXPECT_NEAR(box.box.ymax, expected.ymax, kRounding);
}

TEST_F(Boxes, MotDetections) {
  const auto path = file("det.txt", "2,-1,11,21,30,40,0.5,-1,-1,-1\n1,-1,1,1,5,6,0.9\n\n2,7,2,3,4,5,0.25,-1,-1,-1\n");
  EXPECT_EQ(io::recognise_boxes(path), BoxFormat::mot);
  const BoxFile corner = read_boxes(path, BoxFormat::mot);
  ASSERT_EQ(corner.boxes.size(), 3U);
  ASSERT_EQ(corner.images.size(), 2U);
  EXPECT_EQ(corner.images[0].number, 1);
  EXPECT_TRUE(corner.unsorted);
  EXPECT_EQ(corner.boxes[0].image, 1U);
  EXPECT_EQ(corner.boxes[0].track, -1);
  EXPECT_EQ(corner.boxes[2].track, 7);
  EXPECT_EQ(corner.boxes[2].line, 4U);
  // MOTChallenge counts pixels from 1.
  expect_box(corner.boxes[0], {10, 20, 40, 60});
  const BoxFile raw = read_boxes(path, BoxFormat::mot, {.class_names = {}, .images = {}, .as_in_file = true});
  expect_box(raw.boxes[0], {11, 21, 41, 61});
}

TEST_F(Boxes, MotGroundTruth) {
  const auto path = file("gt.txt", "1,1,11,21,30,40,1,1,0.8\n1,2,11,21,30,40,0,7,1\n");
  const BoxFile gt = read_boxes(path, BoxFormat::mot);
  EXPECT_FALSE(gt.boxes[0].ignored);
  EXPECT_TRUE(gt.boxes[1].ignored);
  EXPECT_EQ(gt.boxes[1].object_class, "7");
}

TEST_F(Boxes, MotRefusals) {
  EXPECT_THAT(refusal(file("a.txt", "1,-1,2,3,four,5,1\n"), BoxFormat::mot),
              ::testing::AllOf(HasSubstr("a.txt"), HasSubstr("line 1"), HasSubstr("'four' in column width")));
  EXPECT_THAT(refusal(file("b.txt", "1,-1,2,3,4,5,1\n1.5,-1,2,3,4,5,1\n"), BoxFormat::mot),
              ::testing::AllOf(HasSubstr("line 2"), HasSubstr("1.5 in column frame")));
  EXPECT_THAT(refusal(file("c.txt", "1,-1,2\n"), BoxFormat::mot), HasSubstr("too few columns"));
  EXPECT_THAT(refusal(file("d.txt", "nan,-1,2,3,4,5,1\n"), BoxFormat::mot), HasSubstr("not a whole number"));
  EXPECT_THAT(refusal(folder_ / "none.txt", BoxFormat::mot), HasSubstr("none.txt"));
  // A box that is not finite is kept for its user to name.
  EXPECT_TRUE(std::isnan(read_boxes(file("e.txt", "1,-1,nan,3,4,5,1\n"), BoxFormat::mot).boxes[0].box.xmin));
}

TEST_F(Boxes, MotWritten) {
  const std::vector<io::MotRow> rows{{1, 3, {499.2961, 156.205, 532.634, 242.567}, 0.985592},
                                     {2, 1, {-0.001, 0, 4, 5}, 1}};
  io::write_mot(folder_ / "out.txt", rows);
  const std::string text = base::read_file(folder_ / "out.txt");
  EXPECT_THAT(text, HasSubstr("1,3,499.30,156.21,33.34,86.36,0.985592,-1,-1,-1\n"));
  EXPECT_THAT(text, HasSubstr("2,1,-0.00,0.00,4.00,5.00,1,-1,-1,-1\n"));
  const std::vector<io::MotRow> bad{{1, 1, {0, 0, std::numeric_limits<double>::infinity(), 1}, 1}};
  EXPECT_THROW(io::write_mot(folder_ / "bad.txt", bad), base::Error);
}

TEST_F(Boxes, CocoGroundTruth) {
  const auto path = file("gt.json", R"({"images": [{"id": 40, "file_name": "b.jpg", "width": 640, "height": 480},
      {"id": 7, "file_name": "a.jpg"}], "categories": [{"id": 18, "name": "boulder"}, {"id": 90, "name": "tree"}],
      "annotations": [{"id": 1, "image_id": 40, "category_id": 90, "bbox": [10.5, 20, 30, 40.25], "iscrowd": 1}]})");
  EXPECT_EQ(io::recognise_boxes(path), BoxFormat::coco);
  const BoxFile coco = read_boxes(path, BoxFormat::coco);
  ASSERT_EQ(coco.images.size(), 2U);
  EXPECT_EQ(coco.images[0], (io::BoxImage{7, "a.jpg", 0, 0}));
  EXPECT_EQ(coco.images[1], (io::BoxImage{40, "b.jpg", 640, 480}));
  ASSERT_EQ(coco.boxes.size(), 1U);
  EXPECT_EQ(coco.boxes[0].image, 1U);
  EXPECT_EQ(coco.boxes[0].object_class, "tree");
  EXPECT_TRUE(coco.boxes[0].ignored);
  expect_box(coco.boxes[0], {10.5, 20, 40.5, 60.25});
}

TEST_F(Boxes, CocoResults) {
  const auto path = file("results.json", R"([{"image_id": 2, "category_id": 1, "bbox": [0, 0, 1, 1], "score": 0.5},
      {"image_id": 1, "category_id": 0, "bbox": [1, 2, 3, 4], "score": 0.25}])");
  const BoxFile coco = read_boxes(path, io::recognise_boxes(path), {.class_names = {"rock", "tree"}, .images = {}});
  ASSERT_EQ(coco.boxes.size(), 2U);
  EXPECT_EQ(coco.boxes[0].object_class, "tree");
  EXPECT_EQ(coco.images[coco.boxes[0].image].number, 2);
  EXPECT_EQ(coco.boxes[1].score, 0.25);
}

TEST_F(Boxes, CocoRefusals) {
  EXPECT_THAT(refusal(file("a.json", R"([{"image_id": 1, "category_id": 1, "bbox": [0, 0, 1]}])"), BoxFormat::coco),
              ::testing::AllOf(HasSubstr("a.json"), HasSubstr("results[0]"), HasSubstr("four numbers")));
  EXPECT_THAT(
      refusal(file("b.json", R"({"images": [{"id": 1, "file_name": "a"}], "categories": [{"id": 1, "name": "x"}],
      "annotations": [{"image_id": 1, "category_id": 1, "bbox": [0,0,1,1]}, {"image_id": 2, "category_id": 1, "bbox": [0,0,1,1]}]})"),
              BoxFormat::coco),
      ::testing::AllOf(HasSubstr("annotations[1]"), HasSubstr("image_id 2")));
  EXPECT_THAT(
      refusal(file("c.json", R"({"images": [{"id": 1, "file_name": "a"}], "categories": [{"id": 1, "name": "x"}],
      "annotations": [{"image_id": 1, "category_id": 5, "bbox": [0,0,1,1]}]})"),
              BoxFormat::coco),
      HasSubstr("category_id 5"));
  EXPECT_THAT(refusal(file("d.json", "[{]"), BoxFormat::coco), HasSubstr("d.json"));
  EXPECT_THAT(refusal(file("e.json", R"([{"image_id": 1, "category_id": 9, "bbox": [0,0,1,1]}])"), BoxFormat::coco,
                      {.class_names = {"x"}, .images = {}}),
              HasSubstr("class number without a name"));
}

TEST_F(Boxes, YoloFolder) {
  image("images/img2.png", 200, 100);
  image("images/img10.png", 400, 300);
  file("labels/img10.txt", "1 0.5 0.5 0.25 0.5 0.75\n");
  file("labels/img2.txt", "0 0.5 0.25 0.1 0.2\n\n");
  file("labels/img3.txt", "");
  file("labels/classes.txt", "rock\ntree\n");
  EXPECT_EQ(io::recognise_boxes(folder_ / "labels"), BoxFormat::yolo);
  const BoxFile yolo = read_boxes(folder_ / "labels", BoxFormat::yolo);
  ASSERT_EQ(yolo.images.size(), 3U);
  EXPECT_EQ(yolo.images[0].name, "img2.png");
  EXPECT_EQ(yolo.images[1].name, "img3");
  EXPECT_EQ(yolo.images[2], (io::BoxImage{-1, "img10.png", 400, 300}));
  ASSERT_EQ(yolo.boxes.size(), 2U);
  EXPECT_EQ(yolo.boxes[0].object_class, "tree");
  EXPECT_EQ(yolo.boxes[0].score, 0.75);
  expect_box(yolo.boxes[0], {150, 75, 250, 225});
  EXPECT_EQ(yolo.boxes[1].object_class, "rock");
  expect_box(yolo.boxes[1], {90, 15, 110, 35});
}

TEST_F(Boxes, YoloRefusals) {
  image("a.png", 200, 100);
  EXPECT_THAT(refusal(file("a.txt", "0 100 50 20 10\n"), BoxFormat::yolo), HasSubstr("not normalised"));
  EXPECT_THAT(refusal(file("a.txt", "0 0.1 0.1 0.2 0.1 0.2 0.3 0.1\n"), BoxFormat::yolo), HasSubstr("segmentation"));
  EXPECT_THAT(refusal(file("a.txt", "0.5 0.1 0.1 0.2 0.1\n"), BoxFormat::yolo),
              HasSubstr("class is not a whole number"));
  EXPECT_THAT(refusal(file("a.txt", "0 0.1 zero 0.2 0.1\n"), BoxFormat::yolo), HasSubstr("'zero'"));
  EXPECT_THAT(refusal(file("b.txt", "0 0.1 0.1 0.2 0.1\n"), BoxFormat::yolo),
              ::testing::AllOf(HasSubstr("image not found"), HasSubstr("--images")));
  EXPECT_THAT(refusal(file("a.txt", "3 0.1 0.1 0.2 0.1\n"), BoxFormat::yolo, {.class_names = {"x"}, .images = {}}),
              HasSubstr("class number without a name"));
}

TEST_F(Boxes, PascalVoc) {
  const auto path =
      file("a.xml", R"(<annotation><filename>IMG_1.JPG</filename><size><width>500</width><height>375</height></size>
    <object><name>boulder</name><difficult>1</difficult><bndbox><xmin>1</xmin><ymin>21</ymin><xmax>100</xmax><ymax>50</ymax></bndbox></object>
    </annotation>)");
  EXPECT_EQ(io::recognise_boxes(path), BoxFormat::voc);
  const BoxFile voc = read_boxes(path, BoxFormat::voc);
  EXPECT_EQ(voc.images[0], (io::BoxImage{-1, "IMG_1.JPG", 500, 375}));
  // Pixels 1 to 100, both included, are 0 to 100 by corners.
  expect_box(voc.boxes[0], {0, 20, 100, 50});
  EXPECT_TRUE(voc.boxes[0].ignored);
  EXPECT_EQ(read_boxes(folder_.path(), io::recognise_boxes(folder_.path())).boxes.size(), 1U);
}

TEST_F(Boxes, PascalVocRefusals) {
  EXPECT_THAT(refusal(file("a.xml", "<annotation>\n<object><name>x</name></object></annotation>"), BoxFormat::voc),
              ::testing::AllOf(HasSubstr("a.xml"), HasSubstr("line 2"), HasSubstr("without a box")));
  EXPECT_THAT(refusal(file("b.xml",
                           "<annotation><object><name>x</name><bndbox><xmin>1</xmin><ymin>2</ymin><xmax>q</xmax>"
                           "<ymax>4</ymax></bndbox></object></annotation>"),
                      BoxFormat::voc),
              HasSubstr("xmax is not a number"));
  EXPECT_THAT(refusal(file("c.xml", "<annotation><object>"), BoxFormat::voc), HasSubstr("c.xml"));
  EXPECT_THAT(refusal(file("d.xml", "<html/>"), BoxFormat::voc), HasSubstr("not a Pascal VOC annotation"));
  // Entities are not expanded.
  const auto bomb =
      file("e.xml",
           "<!DOCTYPE a [<!ENTITY x \"boulder\">]><annotation><object><name>&x;</name><bndbox><xmin>1</xmin>"
           "<ymin>1</ymin><xmax>2</xmax><ymax>2</ymax></bndbox></object></annotation>");
  EXPECT_EQ(read_boxes(bomb, BoxFormat::voc).boxes[0].object_class, "&x;");
}

TEST_F(Boxes, CvatImagesAndTracks) {
  const auto path = file("cvat.xml", R"(<annotations><version>1.1</version><meta><task><original_size><width>640</width>
    <height>480</height></original_size></task></meta>
    <track id="4" label="rock"><box frame="3" outside="0" xtl="1.5" ytl="2" xbr="10" ybr="20"/>
    <box frame="4" outside="1" xtl="1.5" ytl="2" xbr="10" ybr="20"/><box frame="2" xtl="1" ytl="2" xbr="10" ybr="20"/></track>
    </annotations>)");
  EXPECT_EQ(io::recognise_boxes(path), BoxFormat::cvat);
  const BoxFile video = read_boxes(path, BoxFormat::cvat);
  ASSERT_EQ(video.boxes.size(), 2U);
  EXPECT_EQ(video.images[0], (io::BoxImage{2, "", 640, 480}));
  EXPECT_EQ(video.boxes[0].track, 4);
  EXPECT_EQ(video.boxes[0].image, 1U);
  expect_box(video.boxes[0], {1.5, 2, 10, 20});
  const BoxFile images =
      read_boxes(file("images.xml", R"(<annotations><image id="0" name="a.jpg" width="64" height="48">
      <box label="rock" occluded="0" xtl="1" ytl="2" xbr="3" ybr="4"/></image></annotations>)"),
                 BoxFormat::cvat);
  EXPECT_EQ(images.images[0], (io::BoxImage{0, "a.jpg", 64, 48}));
  EXPECT_EQ(images.boxes[0].object_class, "rock");
  EXPECT_THAT(refusal(file("bad.xml", R"(<annotations><track id="1" label="r"><box xtl="1"/></track></annotations>)"),
                      BoxFormat::cvat),
              HasSubstr("no attribute frame"));
}

TEST_F(Boxes, Darknet) {
  image("dog.png", 200, 100);
  const auto json =
      file("result.json", R"([{"frame_id": 1, "filename": "dog.png", "objects": [{"class_id": 16, "name": "dog",
    "relative_coordinates": {"center_x": 0.5, "center_y": 0.5, "width": 0.5, "height": 0.2}, "confidence": 0.98}]},
    {"frame_id": 2, "filename": "gone.png", "objects": []}])");
  EXPECT_EQ(io::recognise_boxes(json), BoxFormat::darknet_json);
  const BoxFile a = read_boxes(json, BoxFormat::darknet_json);
  ASSERT_EQ(a.images.size(), 2U);
  EXPECT_EQ(a.images[0], (io::BoxImage{1, "dog.png", 200, 100}));
  expect_box(a.boxes[0], {50, 40, 150, 60});
  EXPECT_EQ(a.boxes[0].score, 0.98);

  const auto text = file("result.txt",
                         "Enter Image Path: data/dog.jpg: Predicted in 29.7 milli-seconds.\n"
                         "bicycle: 92%\t(left_x:  118   top_y:  124   width:  452   height:  309)\n"
                         "traffic light: 7%\t(left_x:   -3   top_y:  5   width:  10   height:  20)\n"
                         "Enter Image Path: \n");
  EXPECT_EQ(io::recognise_boxes(text), BoxFormat::darknet_txt);
  const BoxFile b = read_boxes(text, BoxFormat::darknet_txt);
  ASSERT_EQ(b.boxes.size(), 2U);
  EXPECT_EQ(b.images[0].name, "dog.jpg");
  EXPECT_EQ(b.boxes[1].object_class, "traffic light");
  EXPECT_NEAR(b.boxes[1].score, 0.07, 1e-12);
  expect_box(b.boxes[0], {118, 124, 570, 433});
  EXPECT_THAT(refusal(file("bad.txt", "a.jpg: Predicted in 1 ms\nx: 9%\t(left_x: 1 top_y: q width: 1 height: 2)\n"),
                      BoxFormat::darknet_txt),
              HasSubstr("line 2"));
  EXPECT_THAT(refusal(file("bad2.txt", "x: 9%\t(left_x: 1 top_y: 1 width: 1 height: 2)\n"), BoxFormat::darknet_txt),
              HasSubstr("before the line that names its image"));
  EXPECT_THAT(refusal(file("bad.json", R"([{"frame_id": 1, "filename": "no.png", "objects": [{"class_id": 1}]}])"),
                      BoxFormat::darknet_json),
              ::testing::AllOf(HasSubstr("element [0]"), HasSubstr("image not found")));
}

TEST_F(Boxes, SurveyTable) {
  const auto path = file("boxes.csv", "image,class,xmin_px,ymin_px,xmax_px,ymax_px,score\nb.jpg,rock,1,2,3,4,0.5\n");
  EXPECT_EQ(io::recognise_boxes(path), BoxFormat::survey_csv);
  expect_box(read_boxes(path, BoxFormat::survey_csv).boxes[0], {1, 2, 3, 4});
}

TEST_F(Boxes, WhatIsNotKnownIsSaid) {
  for (const auto& [name, text] : {std::pair{"a.txt", "hello world\n"}, std::pair{"b.xml", "<html></html>"},
                                   std::pair{"c.csv", "a,b\n1,2\n"}, std::pair{"d.csv", ""}}) {
    try {
      static_cast<void>(io::recognise_boxes(file(name, text)));
      ADD_FAILURE() << name;
    } catch (const base::Error& e) {
      EXPECT_THAT(e.what(), ::testing::AllOf(HasSubstr(name), HasSubstr("--format"), HasSubstr("coco"))) << name;
    }
  }
  EXPECT_THROW(static_cast<void>(io::box_format_from("tfrecord")), base::Error);
  EXPECT_THROW(static_cast<void>(io::recognise_boxes(folder_ / "none")), base::Error);
  for (const auto& name : io::box_format_names()) EXPECT_EQ(io::name_of(io::box_format_from(name)), name);
}

}  // namespace
