// Inference end to end with two real face detectors on a drawn face, whose outline is known.
#include "detection/detector.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/dnn.hpp>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/parallel.hpp"
#include "support/data.hpp"
#include "support/drawn_face.hpp"
#include "support/onnx_bytes.hpp"

namespace {

using namespace cairn;
using cairn::testing::colour_image;
using cairn::testing::draw_face;
using cairn::testing::grey_background;
using cairn::testing::test_data;
using detection::DetectOptions;
using detection::Detector;
using detection::ScoredBox;
using geometry::PixelBox;
using ::testing::HasSubstr;

const auto kYunet = test_data("detectors/yunet_n_320_320.onnx");
const auto kUltraFace = test_data("detectors/version-RFB-320.onnx");

constexpr double kSameFace = 0.6;  // IoU: outlines of a face differ by its hair and chin
constexpr double kSameBox = 0.8;   // IoU: one network on the same face at two scales
constexpr double kSureScore = 0.7;

DetectOptions sure() {
  DetectOptions options;
  options.min_score = kSureScore;
  return options;
}

double iou(const PixelBox& a, const PixelBox& b) {
  return detection::intersection_over_union(a, b);
}

TEST(Detector, KnowsTheModels) {
  const Detector yunet(kYunet, {}, {});
  EXPECT_EQ(yunet.facts().decoder, "yunet");
  EXPECT_EQ(yunet.facts().input_width_px, 320U);
  EXPECT_EQ(yunet.class_name(0), "face");
  const Detector ultra(kUltraFace, {}, {"Gesicht"});
  EXPECT_EQ(ultra.facts().decoder, "scored-boxes");
  EXPECT_EQ(ultra.facts().input_height_px, 240U);
  EXPECT_EQ(ultra.class_name(0), "Gesicht");
}

TEST(Detector, BothNetworksFindTheFaceWhereItIs) {
  for (const auto& model : {kYunet, kUltraFace}) {
    const Detector detector(model, sure(), {});
    cv::Mat image = grey_background(320, 240);
    const PixelBox face = draw_face(image, 190, 120, 100);
    const auto found = detector.detect(colour_image(image));
    ASSERT_EQ(found.size(), 1U) << model;
    EXPECT_GT(iou(found[0].box, face), kSameFace) << model;
    EXPECT_TRUE(detector.detect(colour_image(grey_background(320, 240))).empty()) << model;
  }
}

// The letterbox: in images of other shapes and sizes the box comes out where the face is.
TEST(Detector, FindsTheFaceInImagesOfAnyShape) {
  const Detector detector(kYunet, sure(), {});
  for (const auto& [width, height, x, y, size] :
       {std::array{640, 360, 500, 180, 150}, std::array{360, 640, 120, 480, 150}, std::array{200, 100, 60, 50, 60}}) {
    cv::Mat image = grey_background(width, height);
    const PixelBox face = draw_face(image, x, y, size);
    const auto found = detector.detect(colour_image(image));
    ASSERT_EQ(found.size(), 1U) << width;
    EXPECT_GT(iou(found[0].box, face), kSameFace) << width;
  }
}

// The published decoding (libfacedetection, anchor-free) written down once more on the library's own output.
TEST(Detector, EqualsAnIndependentDecodingOfTheOutputs) {
  cv::Mat image = grey_background(320, 320);
  draw_face(image, 160, 150, 120);
  cv::dnn::Net net = cv::dnn::readNetFromONNX(kYunet.string());
  net.setInput(cv::dnn::blobFromImage(image));
  std::vector<std::vector<double>> rows;  // score, xmin, ymin, xmax, ymax
  for (const int stride : {8, 16, 32}) {
    std::vector<cv::Mat> out;
    const std::string s = std::to_string(stride);
    net.forward(out, std::vector<cv::String>{"cls_" + s, "obj_" + s, "bbox_" + s});
    const int n = 320 / stride;
    for (int row = 0; row < n; ++row)
      for (int column = 0; column < n; ++column) {
        const int i = row * n + column;
        const float* b = out[2].ptr<float>() + 4 * i;
        const double score =
            std::sqrt(static_cast<double>(out[0].ptr<float>()[i]) * static_cast<double>(out[1].ptr<float>()[i]));
        const double cx = (column + static_cast<double>(b[0])) * stride,
                     cy = (row + static_cast<double>(b[1])) * stride;
        const double w = std::exp(static_cast<double>(b[2])) * stride, h = std::exp(static_cast<double>(b[3])) * stride;
        rows.push_back({score, cx - w / 2, cy - h / 2, cx + w / 2, cy + h / 2});
      }
  }
  std::sort(rows.rbegin(), rows.rend());
  const auto found = Detector(kYunet, sure(), {}).detect(colour_image(image));
  ASSERT_EQ(found.size(), 1U);
  constexpr double kFloatPx = 1e-3;
  EXPECT_NEAR(found[0].score, rows[0][0], 1e-6);
  EXPECT_NEAR(found[0].box.xmin, rows[0][1], kFloatPx);
  EXPECT_NEAR(found[0].box.ymin, rows[0][2], kFloatPx);
  EXPECT_NEAR(found[0].box.xmax, rows[0][3], kFloatPx);
  EXPECT_NEAR(found[0].box.ymax, rows[0][4], kFloatPx);
}

// Faces across seams of the tiles are found once, with the box that the untiled look gives.
TEST(Detector, TilesChangeNothingAtTheirSeams) {
  DetectOptions whole = sure(), tiled = sure();
  whole.tile_px = -1;
  tiled.tile_px = 320;
  const Detector untiled(kYunet, whole, {}), detector(kYunet, tiled, {});
  EXPECT_EQ(detector.tiles_of(640, 640), 9U);
  EXPECT_EQ(untiled.tiles_of(640, 640), 1U);
  for (const auto& [x, y] : {std::pair{280, 160}, std::pair{240, 240}, std::pair{320, 320}, std::pair{300, 450}}) {
    cv::Mat image = grey_background(640, 640);
    const PixelBox face = draw_face(image, x, y, 76);
    const auto with = detector.detect(colour_image(image)), without = untiled.detect(colour_image(image));
    ASSERT_EQ(without.size(), 1U) << x;
    ASSERT_EQ(with.size(), 1U) << x;
    EXPECT_GT(iou(with[0].box, without[0].box), kSameBox) << x;
    EXPECT_GT(iou(with[0].box, face), kSameFace) << x;
  }
}

TEST(Detector, LargePhotosAreTiledByThemselves) {
  const Detector detector(kYunet, sure(), {});
  EXPECT_EQ(detector.tiles_of(640, 480), 1U);
  EXPECT_GT(detector.tiles_of(1600, 900), 20U);
  // Six pixels a face after shrinking to 320: only tiles see it.
  cv::Mat image = grey_background(1600, 900);
  const PixelBox face = draw_face(image, 1210, 600, 30);
  const auto found = detector.detect(colour_image(image));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_GT(iou(found[0].box, face), 0.5);
  DetectOptions whole = sure();
  whole.tile_px = -1;
  EXPECT_TRUE(Detector(kYunet, whole, {}).detect(colour_image(image)).empty());
}

TEST(Detector, SameBoxesFromManyThreads) {
  const Detector detector(kYunet, sure(), {});
  cv::Mat image = grey_background(320, 320);
  draw_face(image, 160, 150, 120);
  const auto picture = colour_image(image);
  const auto alone = detector.detect(picture);
  std::vector<std::vector<ScoredBox>> results(6);
  base::parallel_for(results.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) results[i] = detector.detect(picture);
  });
  for (const auto& r : results) EXPECT_EQ(r, alone);
}

TEST(Detector, RefusesModelsItCannotUse) {
  const cairn::testing::TempFolder folder;
  const auto refusal = [&](const std::string& bytes, const DetectOptions& options = {},
                           std::vector<std::string> names = {}) {
    base::write_file(folder / "m.onnx", bytes);
    try {
      const Detector detector(folder / "m.onnx", options, std::move(names));
    } catch (const base::Error& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  // An operator that the library does not know.
  EXPECT_THAT(refusal(cairn::testing::onnx_model("FancyAttention", {1, 3, 32, 32})),
              ::testing::AllOf(HasSubstr("m.onnx"), HasSubstr("by OpenCV"), HasSubstr("Export it again")));
  // A network that gives an image, no boxes.
  EXPECT_THAT(refusal(cairn::testing::onnx_model("Relu", {1, 3, 32, 32})),
              ::testing::AllOf(HasSubstr("m.onnx"), HasSubstr("result 1x3x32x32"), HasSubstr("--decoder")));
  EXPECT_THAT(refusal(cairn::testing::onnx_model("Relu", {1, 8})), HasSubstr("not one image of three channels"));
  EXPECT_THAT(refusal("no model"), HasSubstr("not an ONNX model"));
  EXPECT_THAT(refusal(base::read_file(kYunet).substr(0, 100'000)), HasSubstr("m.onnx"));
  DetectOptions yolo;
  yolo.decoder = "yolo-v8";
  EXPECT_THAT(refusal(base::read_file(kYunet), yolo), HasSubstr("not those of decoder yolo-v8"));
  EXPECT_THAT(refusal(base::read_file(kYunet), {}, {"a", "b"}), HasSubstr("more class names"));
  EXPECT_THROW(Detector(folder / "none.onnx", {}, {}), base::Error);
}

}  // namespace
