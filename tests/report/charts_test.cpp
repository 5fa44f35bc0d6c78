#include "report/charts.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

namespace cairn::report {
namespace {

std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

TEST(NiceCeiling, rounds_up_to_readable_steps) {
  EXPECT_DOUBLE_EQ(nice_ceiling(0.31), 0.4);
  EXPECT_DOUBLE_EQ(nice_ceiling(1.0), 1.0);
  EXPECT_DOUBLE_EQ(nice_ceiling(2.1), 2.5);
  EXPECT_DOUBLE_EQ(nice_ceiling(90.0), 100.0);
  EXPECT_DOUBLE_EQ(nice_ceiling(0.0), 1.0);
}

// North is up and azimuths run clockwise: toward 90 deg the curve lies on +x.
TEST(PolarChart, north_is_up_and_east_is_right) {
  std::vector<double> values(360, 0.25);
  values[0] = 0.5;
  const std::string svg = polar_chart(values, 90.0).str();
  EXPECT_NE(svg.find("d=\"M0 -92L"), std::string::npos) << "0.5 g at the rim, due north";
  EXPECT_NE(svg.find("L46 0L"), std::string::npos) << "0.25 g, half the radius, due east";
  EXPECT_NE(svg.find("x2=\"92\" y2=\"0\""), std::string::npos) << "the critical azimuth";
}

TEST(PolarChart, infinite_values_end_at_the_rim) {
  std::vector<double> values(360, 0.4);
  for (std::size_t i = 100; i < 200; ++i) values[i] = std::numeric_limits<double>::infinity();
  const std::string svg = polar_chart(values, 0.0).str();
  EXPECT_EQ(svg.find("inf"), std::string::npos);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
}

TEST(HistogramChart, bars_on_the_wrong_side_of_the_gate_are_marked) {
  Histogram h{"views", "Views", "", {0, 1, 2, 3, 4, 5}, {10, 10, 10, 10, 10}, 3.0, true};
  EXPECT_EQ(occurrences(histogram_chart(h).str(), "bar fails"), 3U);
  h.gate_is_minimum = false;
  EXPECT_EQ(occurrences(histogram_chart(h).str(), "bar fails"), 2U);
  h.gate.reset();
  EXPECT_EQ(occurrences(histogram_chart(h).str(), "bar fails"), 0U);
}

TEST(HistogramChart, an_empty_histogram_draws_without_dividing_by_zero) {
  const std::string svg = histogram_chart({"x", "X", "", {0, 1}, {0}, {}, true}).str();
  EXPECT_EQ(svg.find("nan"), std::string::npos);
}

TEST(SparkLine, needs_two_values) {
  EXPECT_TRUE(spark_line(std::vector<double>{1.0}, "x").empty());
  EXPECT_FALSE(spark_line(std::vector<double>{1.0, 1.0}, "x").empty());
}

}  // namespace
}  // namespace cairn::report
