#include "report/coverage_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace cairn::report {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

CoveragePage page() {
  CoveragePage p;
  p.title = "Audit of <site>";
  p.coverage.area_m2 = 120.0;
  p.coverage.complete_fraction = 0.875;
  p.coverage.interval_95 = {0.8, 0.93};
  p.coverage.verdicts = {{"passed", 105.0}, {"too_oblique", 15.0}};
  p.coverage.gates = {{"views", "at least 3", 0.9}};
  p.block_m = 4.0;
  CoverageTargetRow row;
  row.label = "7 & <b>";
  row.reasons = "wall, basal band";
  row.wall = 0.25;
  row.wall_by_azimuth = {0.0, 1.0, std::nan(""), 0.5};
  row.basal_by_azimuth = {0.0, 0.0, 0.0, 1.0};
  p.targets.push_back(row);
  p.frames.push_back({"a.jpg", 20.0, 3.0, 0.004, 0.6});
  return p;
}

TEST(CoveragePage, ShowsWhatWasFoundAndEscapesIt) {
  const std::string html = render_coverage_page(page());
  EXPECT_THAT(html, HasSubstr("Audit of &lt;site&gt;"));
  EXPECT_THAT(html, HasSubstr("87.5"));
  EXPECT_THAT(html, HasSubstr("80.0\u202f% to 93.0\u202f%, blocks of 4.0"));
  EXPECT_THAT(html, HasSubstr("7 &amp; &lt;b&gt;"));
  EXPECT_THAT(html, HasSubstr("fails: wall, basal band"));
  EXPECT_THAT(html, HasSubstr("0 of 1 targets pass"));
  EXPECT_THAT(html, HasSubstr("class=\"n bad\">0.60"));  // blurred more than the limit
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, Not(HasSubstr(">nan")));
  EXPECT_EQ(html, render_coverage_page(page()));
}

TEST(CoveragePage, MapsKeepHolesAndNoData) {
  geometry::Grid<float> counts({0.0, 4.0, 1.0, 4, 4}, 5.0F);
  counts.values[0] = kNan;
  counts.values[5] = 0.0F;
  const CoverageMap map = count_map(counts, "Views", "", 3);
  ASSERT_EQ(map.image.pixels.size(), 16U);
  EXPECT_EQ(map.image.palette[map.image.pixels[0]][3], 0);  // clear
  EXPECT_EQ(map.image.palette[map.image.pixels[5]], map.keys[0].colour);
  EXPECT_EQ(map.image.palette[map.image.pixels[6]], map.keys[3].colour);
  EXPECT_EQ(map.keys.size(), 4U);

  const CoverageMap metric = metric_map(counts, "GSD", "", "mm", 0.0, 5.0, true);
  EXPECT_EQ(metric.image.pixels[0], 0);
  EXPECT_EQ(metric.image.palette[metric.image.pixels[5]], metric.keys.front().colour);
  EXPECT_EQ(metric.image.palette[metric.image.pixels[6]], metric.keys.back().colour);
}

TEST(CoveragePage, AHoleOfOneCellSurvivesShrinking) {
  geometry::Grid<float> counts({0.0, 2000.0, 1.0, 2000, 2000}, 5.0F);
  counts.at(1000, 1000) = 0.0F;
  const CoverageMap map = count_map(counts, "Views", "", 3);
  ASSERT_LT(map.image.width, 2000U);
  const auto hole = std::count_if(map.image.pixels.begin(), map.image.pixels.end(),
                                  [&](std::uint8_t p) { return map.image.palette[p] == map.keys[0].colour; });
  EXPECT_EQ(hole, 1);
}

}  // namespace
}  // namespace cairn::report
