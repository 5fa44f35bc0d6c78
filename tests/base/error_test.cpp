#include "base/error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/result.hpp"

namespace cairn::base {
namespace {

TEST(Error, SaysFileRecordFoundAllowedAndRemedy) {
  Error e = Error(ErrorCode::invalid_input, "box outside the image")
                .file("detections.csv")
                .record("line 7")
                .found("xmax_px = 1700")
                .allowed("0 to 1600")
                .hint("Scale the boxes");
  e.in("stage locate");
  EXPECT_STREQ(
      e.what(),
      "detections.csv, line 7: box outside the image (found xmax_px = 1700; allowed 0 to 1600). Scale the boxes "
      "[stage locate]");
}

TEST(Error, DefaultFileDoesNotReplaceAKnownOne) {
  Error known = Error(ErrorCode::invalid_input, "x").file("a");
  known.default_file("b");
  EXPECT_EQ(known.file(), "a");
  Error unknown(ErrorCode::invalid_input, "x");
  unknown.default_file("b");
  EXPECT_EQ(unknown.file(), "b");
}

// docs/exit_codes.md
TEST(Error, ExitCodesAreThoseOfTheDesign) {
  const std::pair<ErrorCode, int> expected[] = {
      {ErrorCode::internal, 1},     {ErrorCode::invalid_argument, 2},    {ErrorCode::invalid_input, 4},
      {ErrorCode::not_found, 4},    {ErrorCode::failed_precondition, 4}, {ErrorCode::resource_exhausted, 5},
      {ErrorCode::crs_mismatch, 6}, {ErrorCode::already_exists, 7},      {ErrorCode::cancelled, 8},
      {ErrorCode::quality_gate, 9}};
  for (const auto& [code, exit] : expected) EXPECT_EQ(static_cast<int>(exit_code(code)), exit) << name_of(code);
}

TEST(Result, GivesTheValueOrThrowsTheError) {
  const Result<int> good(3);
  EXPECT_TRUE(good.ok());
  EXPECT_EQ(good.value(), 3);
  const Result<int> bad(Error(ErrorCode::not_found, "none"));
  EXPECT_FALSE(bad.ok());
  EXPECT_THROW((void)bad.value(), Error);
}

}  // namespace
}  // namespace cairn::base
