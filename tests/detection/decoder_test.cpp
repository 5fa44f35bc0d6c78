#include "detection/decoder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.hpp"

namespace {

using namespace cairn::detection;
using ::testing::HasSubstr;

constexpr double kFloatPx = 1e-4;  // px: outputs are 32-bit numbers of up to 320

Tensor tensor(const std::string& name, std::vector<std::size_t> dims, std::vector<float> values = {}) {
  std::size_t count = 1;
  for (const auto d : dims) count *= d;
  values.resize(count, 0.0F);
  return {{name, std::move(dims)}, std::move(values)};
}

void expect_box(const ScoredBox& found, const cairn::geometry::PixelBox& box, std::size_t object_class, double score) {
  EXPECT_NEAR(found.box.xmin, box.xmin, kFloatPx);
  EXPECT_NEAR(found.box.ymin, box.ymin, kFloatPx);
  EXPECT_NEAR(found.box.xmax, box.xmax, kFloatPx);
  EXPECT_NEAR(found.box.ymax, box.ymax, kFloatPx);
  EXPECT_EQ(found.object_class, object_class);
  EXPECT_NEAR(found.score, score, 1e-6);
}

TEST(Decode, YoloV5) {
  const auto t = tensor("output0", {1, 3, 7}, {100, 50,  20, 10, 0.5F, 0.2F, 0.8F,  //
                                               10,  10,  5,  5,  0.1F, 1,    0,     //
                                               200, 100, 40, 30, 1,    0.9F, 0.3F});
  const auto found = decode(Decoder::yolo_v5, std::span(&t, 1), {320, 320}, 0.3);
  ASSERT_EQ(found.size(), 2U);
  expect_box(found[0], {90, 45, 110, 55}, 1, 0.4);
  expect_box(found[1], {180, 85, 220, 115}, 0, 0.9);
}

TEST(Decode, YoloV8IsTheTransposeWithoutObjectness) {
  // Two boxes, three classes: rows x, y, w, h, c0, c1, c2.
  const auto t = tensor("output0", {1, 7, 2}, {100, 200, 50, 100, 20, 40, 10, 30, 0.1F, 0.7F, 0.6F, 0.2F, 0.3F, 0.1F});
  const auto found = decode(Decoder::yolo_v8, std::span(&t, 1), {320, 320}, 0.3);
  ASSERT_EQ(found.size(), 2U);
  expect_box(found[0], {90, 45, 110, 55}, 1, 0.6);
  expect_box(found[1], {180, 85, 220, 115}, 0, 0.7);
}

TEST(Decode, EndToEnd) {
  const auto t = tensor("output0", {1, 2, 6}, {1, 2, 30, 40, 0.8F, 5, 0, 0, 0, 0, 0, 0});
  const auto found = decode(Decoder::end_to_end, std::span(&t, 1), {320, 320}, 0.3);
  ASSERT_EQ(found.size(), 1U);
  expect_box(found[0], {1, 2, 30, 40}, 5, 0.8);
}

// 64 x 32 input: 32 + 8 + 2 cells. The second row of stride 16 stands at row 32 + 4.
TEST(Decode, Yolox) {
  auto t = tensor("output", {1, 42, 6});
  const std::size_t row = 32 + 4 + 1;  // cell (1, 1) of stride 16
  const float values[6] = {0.5F, 0.25F, std::log(2.0F), std::log(1.5F), 0.9F, 0.5F};
  for (std::size_t i = 0; i < 6; ++i) t.values[row * 6 + i] = values[i];
  const auto found = decode(Decoder::yolox, std::span(&t, 1), {64, 32}, 0.3);
  ASSERT_EQ(found.size(), 1U);
  expect_box(found[0], {1.5 * 16 - 16, 1.25 * 16 - 12, 1.5 * 16 + 16, 1.25 * 16 + 12}, 0, 0.45);
}

TEST(Decode, DarknetLayersAreSharesOfTheInput) {
  const std::vector<Tensor> layers{tensor("a", {1, 6}, {0.5F, 0.5F, 0.1F, 0.2F, 0.9F, 0.8F}),
                                   tensor("b", {2, 6}, {0.25F, 0.5F, 0.1F, 0.2F, 0.9F, 0.7F, 0, 0, 0, 0, 0, 0})};
  const auto found = decode(Decoder::darknet, layers, {416, 208}, 0.3);
  ASSERT_EQ(found.size(), 2U);
  expect_box(found[0], {0.45 * 416, 0.4 * 208, 0.55 * 416, 0.6 * 208}, 0, 0.8);
  expect_box(found[1], {0.20 * 416, 0.4 * 208, 0.30 * 416, 0.6 * 208}, 0, 0.7);
}

TEST(Decode, ScoredBoxesInEitherOrder) {
  const auto scores = tensor("scores", {1, 2, 2}, {0.9F, 0.1F, 0.2F, 0.8F});
  const auto boxes = tensor("boxes", {1, 2, 4}, {0, 0, 1, 1, 0.25F, 0.5F, 0.5F, 0.75F});
  for (const auto& outputs : {std::vector<Tensor>{scores, boxes}, std::vector<Tensor>{boxes, scores}}) {
    const auto found = decode(Decoder::scored_boxes, outputs, {320, 240}, 0.3);
    ASSERT_EQ(found.size(), 1U);
    expect_box(found[0], {80, 120, 160, 180}, 0, 0.8);
  }
}

std::vector<Tensor> yunet_outputs() {
  std::vector<Tensor> outputs;
  for (const std::size_t s : {8U, 16U, 32U}) {
    const std::size_t cells = (64 / s) * (64 / s);
    outputs.push_back(tensor("cls_" + std::to_string(s), {1, cells, 1}));
    outputs.push_back(tensor("obj_" + std::to_string(s), {1, cells, 1}));
    outputs.push_back(tensor("bbox_" + std::to_string(s), {1, cells, 4}));
  }
  return outputs;
}

TEST(Decode, Yunet) {
  auto outputs = yunet_outputs();
  // Cell (2, 1) of stride 16: row 1 * 4 + 2.
  outputs[3].values[6] = 0.64F;
  outputs[4].values[6] = 1.2F;  // scores above 1 count as 1
  const float box[4] = {0.5F, 0.0F, std::log(2.0F), 0.0F};
  for (std::size_t i = 0; i < 4; ++i) outputs[5].values[4 * 6 + i] = box[i];
  const auto found = decode(Decoder::yunet, outputs, {64, 64}, 0.3);
  ASSERT_EQ(found.size(), 1U);
  expect_box(found[0], {2.5 * 16 - 16, 16 - 8, 2.5 * 16 + 16, 16 + 8}, 0, 0.8);
}

TEST(Decode, BoxesThatAreNoneAreLeftOut) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto t = tensor("o", {1, 7, 6}, {nan,   1, 1,     1,  1, 1,    //
                                         1,     1, 0,     1,  1, 1,    //
                                         1,     1, 1,     -1, 1, 1,    //
                                         1,     1, 1,     1,  1, nan,  //
                                         5,     5, 2,     2,  1, 1,    //
                                         1e38F, 1, 1e38F, 1,  1, nan, 1, 1, 1, 1, nan, 1});
  const auto found = decode(Decoder::yolo_v5, std::span(&t, 1), {32, 32}, 0.0);
  ASSERT_EQ(found.size(), 1U);
  expect_box(found[0], {4, 4, 6, 6}, 0, 1.0);
}

TEST(RecogniseDecoder, ByNamesAndShapes) {
  EXPECT_EQ(recognise_decoder({{"output0", {1, 25200, 85}}}), Decoder::yolo_v5);
  EXPECT_EQ(recognise_decoder({{"output0", {1, 6300, 6}}}), Decoder::yolo_v5);
  EXPECT_EQ(recognise_decoder({{"output0", {1, 84, 8400}}}), Decoder::yolo_v8);
  EXPECT_EQ(recognise_decoder({{"output0", {1, 5, 8400}}}), Decoder::yolo_v8);
  EXPECT_EQ(recognise_decoder({{"output0", {1, 300, 6}}}), Decoder::end_to_end);
  EXPECT_EQ(recognise_decoder({{"a", {507, 85}}, {"b", {2028, 85}}}), Decoder::darknet);
  EXPECT_EQ(recognise_decoder({{"scores", {1, 4420, 2}}, {"boxes", {1, 4420, 4}}}), Decoder::scored_boxes);
  EXPECT_EQ(recognise_decoder({{"boxes", {1, 4420, 4}}, {"scores", {1, 4420, 4}}}), Decoder::scored_boxes);
  std::vector<TensorShape> yunet;
  for (const auto& t : yunet_outputs()) yunet.push_back(t.shape);
  yunet.push_back({"kps_8", {1, 64, 10}});
  EXPECT_EQ(recognise_decoder(yunet), Decoder::yunet);
}

TEST(RecogniseDecoder, UnknownOutputsAreListed) {
  for (const auto& shapes :
       {std::vector<TensorShape>{{"logits", {1, 1000}}}, std::vector<TensorShape>{},
        std::vector<TensorShape>{{"map", {1, 3, 80, 80}}}, std::vector<TensorShape>{{"logits", {1, 4, 4}}}}) {
    try {
      static_cast<void>(recognise_decoder(shapes));
      ADD_FAILURE();
    } catch (const cairn::base::Error& e) {
      EXPECT_EQ(e.code(), cairn::base::ErrorCode::invalid_input);
      EXPECT_THAT(e.what(), HasSubstr("--decoder"));
      if (!shapes.empty()) {
        EXPECT_THAT(e.what(), HasSubstr(describe(shapes)));
      }
    }
  }
}

TEST(Decode, RefusesTheOutputsOfAnother) {
  const auto t = tensor("output0", {1, 3, 4});
  for (const auto& name : decoder_names()) {
    const auto decoder = decoder_from(name);
    ASSERT_TRUE(decoder) << name;
    EXPECT_EQ(name_of(*decoder), name);
    EXPECT_THROW(static_cast<void>(decode(*decoder, std::span(&t, 1), {32, 32}, 0.3)), cairn::base::Error) << name;
  }
  const auto grid = tensor("output", {1, 41, 6});
  EXPECT_THROW(static_cast<void>(decode(Decoder::yolox, std::span(&grid, 1), {64, 32}, 0.3)), cairn::base::Error);
}

}  // namespace
