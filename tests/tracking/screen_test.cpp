#include "tracking/screen.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace {

using namespace cairn::tracking;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

TEST(ScreenBoxes, NamesEachFault) {
  const std::vector<BoxObservation> boxes{
      {{0, 0, 10, 10}, 0, 0.9},   {{0, 0, 10, 10}, 0, 0.5},       {{0, 0, 10, 10}, 1, 0.9}, {{0, 0, kNan, 10}, 0, 0.9},
      {{0, 0, kInf, 10}, 0, 0.9}, {{0, 0, 10, 10}, 0, kNan},      {{0, 0, 0, 10}, 0, 0.9},  {{0, 0, 10, 0}, 0, 0.9},
      {{10, 0, 0, 10}, 0, 0.9},   {{0, 0, 1e200, 1e200}, 0, 0.9}, {{5, 0, 10, 10}, 0, 0.1}};
  using enum BoxFault;
  EXPECT_EQ(screen_boxes(boxes, 0.3, false),
            (std::vector<BoxFault>{none, duplicate_box, none, non_finite_box, non_finite_box, non_finite_box,
                                   zero_area_box, zero_area_box, negative_size_box, non_finite_box, low_score}));
  EXPECT_EQ(screen_boxes(boxes, 0.3, true)[1], none);
  for (const auto fault : {non_finite_box, negative_size_box, zero_area_box, duplicate_box, low_score})
    EXPECT_FALSE(describe(fault, boxes[0]).empty());
  EXPECT_STREQ(name_of(zero_area_box), "zero_area_box");
}

}  // namespace
