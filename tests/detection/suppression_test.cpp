#include "detection/suppression.hpp"

#include <gtest/gtest.h>

namespace {

using namespace cairn::detection;

TEST(Suppress, TheBestOfEachPlaceAndClassStays) {
  const std::vector<ScoredBox> boxes{
      {{0, 0, 10, 10}, 0, 0.6}, {{1, 0, 11, 10}, 0, 0.9}, {{1, 0, 11, 10}, 1, 0.5}, {{50, 0, 60, 10}, 0, 0.4}};
  EXPECT_EQ(suppress(boxes, 0.45), (std::vector<ScoredBox>{boxes[1], boxes[2], boxes[3]}));
  // IoU of the first two is 9 / 11.
  EXPECT_EQ(suppress(boxes, 0.82).size(), 4U);
}

TEST(Suppress, TiesGoToTheFirst) {
  const std::vector<ScoredBox> boxes{{{0, 0, 10, 10}, 0, 0.5}, {{0, 0, 10, 11}, 0, 0.5}};
  EXPECT_EQ(suppress(boxes, 0.5), std::vector<ScoredBox>{boxes[0]});
}

TEST(Share, ByHand) {
  EXPECT_DOUBLE_EQ(share_inside({0, 0, 2, 2}, {1, 0, 10, 10}), 0.5);
  EXPECT_DOUBLE_EQ(intersection_over_union({0, 0, 2, 2}, {1, 1, 3, 3}), 1.0 / 7.0);
  EXPECT_DOUBLE_EQ(intersection_over_union({0, 0, 2, 2}, {5, 5, 6, 6}), 0.0);
}

}  // namespace
