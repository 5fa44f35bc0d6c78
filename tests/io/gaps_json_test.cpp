#include "io/gaps_json.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using ::testing::HasSubstr;

GapsFile example() {
  survey::CoverageGap gap;
  gap.id = survey::GapId(3);
  gap.rings = {{{0.1, 0.2}, {10.0, 0.0}, {10.0, 10.0 / 3.0}}, {{2.0, 1.0}, {3.0, 2.0}, {4.0, 1.0}}};
  gap.centre = {5.0, 2.0, 0.7};
  gap.area_m2 = 12.3;
  gap.facets = 17;
  gap.reason = "no_view";
  gap.nearest_frames = {survey::FrameId(4), survey::FrameId(1)};
  gap.view = survey::SuggestedView{{1.0, 2.0, 30.0}, {5.0, 2.0, 0.7}};
  survey::CoverageGap bare = gap;
  bare.id = survey::GapId(4);
  bare.view.reset();
  bare.nearest_frames.clear();
  return {{{46.8, -92.0, 198.0}, survey::HeightType::ellipsoidal, ""}, {gap, bare}};
}

TEST(GapsJson, RoundTrip) {
  const testing::TempFolder folder;
  const GapsFile written = example();
  write_gaps(folder / "gaps.json", written);
  const GapsFile read = read_gaps(folder / "gaps.json");
  ASSERT_EQ(read.gaps.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(to_json(read.gaps[i]), to_json(written.gaps[i]));
  EXPECT_EQ(read.gaps[0].rings, written.gaps[0].rings);
  EXPECT_EQ(read.gaps[0].view->position, written.gaps[0].view->position);
  EXPECT_FALSE(read.gaps[1].view.has_value());
}

TEST(GapsJson, RefusesBadFiles) {
  const testing::TempFolder folder;
  const auto error_of = [&](GapsFile file, const std::string& from, const std::string& to) -> std::string {
    try {
      write_gaps(folder / "gaps.json", file);
      std::string text = base::read_file(folder / "gaps.json");
      if (!from.empty()) text.replace(text.find(from), from.size(), to);
      base::write_file(folder / "gaps.json", text);
      (void)read_gaps(folder / "gaps.json");
    } catch (const base::Error& error) {
      EXPECT_EQ(error.code(), base::ErrorCode::invalid_input);
      return error.what();
    }
    return "no error";
  };
  EXPECT_THAT(error_of(example(), "\"reason\"", "\"season\""), HasSubstr("gap 1"));
  EXPECT_THAT(error_of(example(), "\"id\": 4", "\"id\": 3"), HasSubstr("gap 2"));
  EXPECT_THAT(error_of(example(), "12.3", "-12.3"), HasSubstr("negative"));
  GapsFile thin = example();
  thin.gaps[0].rings[0].resize(2);
  EXPECT_THAT(error_of(thin, "", ""), HasSubstr("encloses nothing"));
  GapsFile nan = example();
  nan.gaps[0].rings[0][0].x() = std::nan("");
  EXPECT_THAT(error_of(nan, "", ""), HasSubstr("finite"));
}

}  // namespace
}  // namespace cairn::io
