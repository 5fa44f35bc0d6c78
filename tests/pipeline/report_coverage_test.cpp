#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "io/gaps_json.hpp"
#include "pipeline/report_parts.hpp"
#include "support/data.hpp"

namespace cairn::pipeline {
namespace {

TEST(ReadCoverageView, TakesFiguresGatesVerdictsAndGaps) {
  const testing::TempFolder folder;
  base::write_file(folder / "coverage.json", R"({"facets": 12, "area_m2": 80.5, "completeness": 0.75,
    "area_m2_by_verdict": {"passed": 60, "occluded": 20.5},
    "gates": [{"name": "incidence", "rule": "at most 60 deg in two views", "pass_fraction": 0.9}],
    "histograms": [{"metric": "parallax_deg", "title": "P", "unit": "deg", "edges": [0, 5, 10, 15, 20],
                    "areas_m2": [0, 4, 0, 0], "gate": 10, "gate_is_minimum": true}]})");
  survey::CoverageGap gap;
  gap.id = survey::GapId(3);
  gap.rings = {{{0, 0}, {2, 0}, {0, 2}}};
  gap.area_m2 = 2.0;
  gap.reason = "occluded";
  gap.nearest_frames = {survey::FrameId(7), survey::FrameId(9)};
  survey::Survey survey;
  survey.frames.resize(1);
  survey.frames[0].id = survey::FrameId(7);
  survey.frames[0].image = "photos/a.jpg";
  io::write_gaps(folder / "gaps.json", {survey.manifest.origin, {gap}});

  const auto view = read_coverage_view({folder.path(), {}, {}, false}, survey, std::nullopt);
  ASSERT_TRUE(view.has_value());
  EXPECT_EQ(view->facets, 12U);
  EXPECT_DOUBLE_EQ(view->area_m2, 80.5);
  EXPECT_DOUBLE_EQ(view->complete_fraction, 0.75);
  ASSERT_EQ(view->verdicts.size(), 2U);
  EXPECT_EQ(view->verdicts[1].verdict, "occluded");
  EXPECT_EQ(view->gates.at(0).rule, "at most 60° in two views");
  ASSERT_EQ(view->histograms.size(), 1U);
  EXPECT_EQ(view->histograms[0].unit, "°");
  // The bins behind the gate are empty and go; the one that ends at the gate stays.
  EXPECT_EQ(view->histograms[0].edges, (std::vector<double>{0, 5, 10, 15}));
  ASSERT_EQ(view->gaps.size(), 1U);
  EXPECT_EQ(view->gaps[0].nearest_frames, (std::vector<std::string>{"a.jpg", "frame 9"}));
}

TEST(ReadCoverageView, ThinTailsAreFoldedAndNoAreaIsLost) {
  const testing::TempFolder folder;
  std::string edges = "0", areas = "0.1";
  for (int i = 1; i <= 100; ++i) {
    edges += "," + std::to_string(i);
    if (i < 100) areas += i >= 40 && i < 50 ? ",100" : i == 99 ? ",0.5" : ",0";
  }
  base::write_file(folder / "coverage.json", R"({"histograms": [{"metric": "gsd_mm", "title": "G", "unit": "mm/px",
    "edges": [)" + edges + "], \"areas_m2\": [" + areas +
                                                 "]}]}");
  const auto view = read_coverage_view({folder.path(), {}, {}, false}, {}, std::nullopt);
  const auto& h = view->histograms.at(0);
  EXPECT_EQ(h.edges.front(), 40.0);
  EXPECT_EQ(h.edges.back(), 50.0);
  double total = 0.0;
  for (const double a : h.areas_m2) total += a;
  EXPECT_NEAR(total, 1000.6, 1e-9);
}

TEST(ReadCoverageView, HistogramsComeFromTheRasterWhereTheFileHasNone) {
  const testing::TempFolder folder;
  base::write_file(folder / "coverage.json", R"({"facets": 4, "area_m2": 1, "completeness": 1})");
  geometry::Grid<float> views({0.0, 1.0, 0.5, 2, 2}, 3.0F);
  views.values[0] = 1.0F;
  io::Raster raster;
  raster.bands = {{"views", "", "", views, std::nullopt}};
  const auto view = read_coverage_view({folder.path(), {}, {}, false}, {}, raster);
  ASSERT_EQ(view->histograms.size(), 1U);
  EXPECT_EQ(view->histograms[0].areas_m2, (std::vector<double>{0, 0.25, 0, 0.75}));
}

TEST(ReadCoverageView, ARecipeWithoutTheStageHasNone) {
  const testing::TempFolder folder;
  base::write_file(folder / "coverage.json", "{}");
  EXPECT_FALSE(read_coverage_view({folder.path(), {}, {"locate"}, false}, {}, std::nullopt).has_value());
  EXPECT_TRUE(read_coverage_view({folder.path(), {}, {"coverage"}, false}, {}, std::nullopt).has_value());
}

}  // namespace
}  // namespace cairn::pipeline
