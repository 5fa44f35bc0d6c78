#include "report/drive_figure.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.hpp"

namespace cairn::report {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

DriveFigure figure() {
  DriveFigure f;
  f.title = "A < B";
  f.min = {0.0, 0.0};
  f.max = {10.0, 5.0};
  f.width_px = 1028.0;  // 100 px a metre between the margins
  f.tracks.push_back({"way", "#0072b2", true, {{0.0, 0.0}, {10.0, 5.0}}});
  f.tracks.push_back({"", "#999999", false, {{1.0, 1.0}, {2.0, 1.0}}});
  f.outlines.push_back({{{1.0, 1.0}, {2.0, 1.0}, {2.0, 2.0}}, "none", "#d55e00"});
  f.marks.push_back({{10.0, 5.0}, "goal"});
  return f;
}

TEST(DriveFigure, PutsPlacesWhereTheyAre) {
  const std::string svg = drive_figure_svg(figure());
  // North is up: the south-western corner lies at the left and the bottom.
  EXPECT_THAT(svg, HasSubstr("points=\"14.0,530.0 1014.0,30.0\""));
  EXPECT_THAT(svg, HasSubstr("<polygon points=\"114.0,430.0 214.0,430.0 214.0,330.0\""));
  EXPECT_THAT(svg, HasSubstr("stroke-dasharray"));
  EXPECT_THAT(svg, HasSubstr("A &lt; B"));
  EXPECT_THAT(svg, HasSubstr(">way<"));
  EXPECT_THAT(svg, HasSubstr(">goal<"));
  EXPECT_THAT(svg, Not(HasSubstr("<image")));
}

TEST(DriveFigure, ACostmapIsItsGround) {
  DriveFigure f = figure();
  f.cost = geometry::Grid<std::uint8_t>({0.0, 5.0, 0.5, 20, 10}, 0);
  f.cost.at(3, 4) = 254;
  EXPECT_THAT(drive_figure_svg(f), HasSubstr("data:image/png;base64,"));
}

TEST(DriveFigure, NothingToShowIsAnError) {
  EXPECT_THROW(static_cast<void>(drive_figure_svg({})), base::Error);
  EXPECT_THROW(static_cast<void>(update_periods_svg("x", {}, {}, 0.25)), base::Error);
  EXPECT_THROW(static_cast<void>(update_periods_svg("x", {1.0}, {}, 0.25)), base::Error);
}

TEST(DriveFigure, PeriodsTellMeanAndGreatest) {
  EXPECT_THAT(update_periods_svg("Park", {1.0, 2.0, 4.0}, {0.5, 1.0, 2.0}, 0.25),
              HasSubstr("Park: mean 1.17 s, greatest 2.00 s"));
}

}  // namespace
}  // namespace cairn::report
