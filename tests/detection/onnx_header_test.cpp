#include "detection/onnx_header.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "support/data.hpp"
#include "support/onnx_bytes.hpp"

namespace {

using namespace cairn;
using detection::read_onnx_header;
using ::testing::ElementsAre;

TEST(OnnxHeader, OfRealModels) {
  const auto yunet =
      read_onnx_header(base::read_file(cairn::testing::test_data("detectors/yunet_n_320_320.onnx")), "yunet");
  ASSERT_EQ(yunet.inputs.size(), 1U);
  EXPECT_EQ(yunet.inputs[0].name, "input");
  EXPECT_THAT(yunet.inputs[0].dims, ElementsAre(1, 3, 320, 320));
  ASSERT_EQ(yunet.outputs.size(), 12U);
  EXPECT_EQ(yunet.outputs[0].name, "cls_8");
  const auto ultra =
      read_onnx_header(base::read_file(cairn::testing::test_data("detectors/version-RFB-320.onnx")), "ultra");
  // An old file that lists its weights among the inputs.
  ASSERT_EQ(ultra.inputs.size(), 1U);
  EXPECT_THAT(ultra.inputs[0].dims, ElementsAre(1, 3, 240, 320));
  ASSERT_EQ(ultra.outputs.size(), 2U);
}

TEST(OnnxHeader, OpenSizesAndMetadata) {
  const auto header = read_onnx_header(
      cairn::testing::onnx_model("Relu", {1, 3, 0, 0},
                                 {{"stride", "32"}, {"names", "{0: 'rock', 1: \"boulder's\", 2: 'tree'}"}}),
      "m");
  EXPECT_THAT(header.inputs[0].dims, ElementsAre(1, 3, -1, -1));
  ASSERT_NE(header.find("stride"), nullptr);
  EXPECT_EQ(*header.find("stride"), "32");
  EXPECT_EQ(header.find("author"), nullptr);
  EXPECT_THAT(detection::class_names_from_metadata(header), ElementsAre("rock", "boulder's", "tree"));
}

TEST(OnnxHeader, NamesThatCannotBeReadAreNone) {
  for (const auto* text : {"", "rock, tree", "{0: rock}", "{0: 'rock", "{1: 'rock'}", "{a: 'rock'}"})
    EXPECT_TRUE(detection::class_names_from_metadata(
                    read_onnx_header(cairn::testing::onnx_model("Relu", {1, 3, 8, 8}, {{"names", text}}), "m"))
                    .empty())
        << text;
}

TEST(OnnxHeader, CutAnywhereIsAnErrorNotACrash) {
  const std::string whole = cairn::testing::onnx_model("Relu", {1, 3, 8, 8}, {{"names", "{0: 'a'}"}});
  int refused = 0;
  for (std::size_t length = 0; length < whole.size(); ++length) {
    try {
      static_cast<void>(read_onnx_header(whole.substr(0, length), "cut"));
    } catch (const base::Error& e) {
      ++refused;
      EXPECT_EQ(e.code(), base::ErrorCode::invalid_input);
      EXPECT_EQ(e.file(), "cut");
    }
  }
  EXPECT_GT(refused, 50);
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ 0x5A);
    try {
      static_cast<void>(read_onnx_header(changed, "changed"));
    } catch (const base::Error&) {
    }
  }
  EXPECT_THROW(static_cast<void>(read_onnx_header("hello world, no model", "text")), base::Error);
}

}  // namespace
