#include "tracking/box_matching.hpp"

#include <gtest/gtest.h>

#include "base/random.hpp"
#include "tracking/reference_sort.hpp"

namespace {

using namespace cairn;
using geometry::PixelBox;
using tracking::ClassedBox;
using tracking::kNoMatch;
using tracking::match_boxes;

TEST(IntersectionOverUnion, ByHand) {
  EXPECT_DOUBLE_EQ(tracking::intersection_over_union({0, 0, 2, 2}, {1, 1, 3, 3}), 1.0 / 7.0);
  EXPECT_DOUBLE_EQ(tracking::intersection_over_union({0, 0, 2, 2}, {0, 0, 2, 2}), 1.0);
  EXPECT_DOUBLE_EQ(tracking::intersection_over_union({0, 0, 2, 2}, {2, 0, 4, 2}), 0.0);
}

TEST(MatchBoxes, NothingToMatch) {
  EXPECT_TRUE(match_boxes({}, {}, 0.3).empty());
  const std::vector<ClassedBox> one{{{0, 0, 10, 10}, 0}};
  EXPECT_EQ(match_boxes(one, {}, 0.3), std::vector<std::size_t>{kNoMatch});
  EXPECT_TRUE(match_boxes({}, one, 0.3).empty());
}

// IoU of [0,2] and [1,3] wide boxes of one height: 1/3, exactly representable nowhere but equal on both sides.
TEST(MatchBoxes, EqualityCountsOnlyWhereTheAssignmentIsSolved) {
  const std::vector<ClassedBox> detection{{{0, 0, 2, 3}, 0}};
  const std::vector<ClassedBox> track{{{1, 0, 3, 3}, 0}};
  const double third = tracking::intersection_over_union(detection[0].box, track[0].box);
  // No pair is above the threshold: the assignment is solved, and a pair at the threshold stays.
  EXPECT_EQ(match_boxes(detection, track, third), std::vector<std::size_t>{0});
  // Another pair is above it and alone: the shortcut takes that one only.
  const std::vector<ClassedBox> two_detections{{{0, 0, 2, 3}, 0}, {{50, 0, 60, 10}, 0}};
  const std::vector<ClassedBox> two_tracks{{{1, 0, 3, 3}, 0}, {{50, 0, 60, 10}, 0}};
  EXPECT_EQ(match_boxes(two_detections, two_tracks, third), (std::vector<std::size_t>{kNoMatch, 1}));
}

TEST(MatchBoxes, OtherClassesNeverMatch) {
  const std::vector<ClassedBox> detections{{{0, 0, 10, 10}, 1}}, tracks{{{0, 0, 10, 10}, 2}};
  EXPECT_EQ(match_boxes(detections, tracks, 0.3), std::vector<std::size_t>{kNoMatch});
}

// The assignment gives up the best single pair for a better sum.
TEST(MatchBoxes, SumDecidesNotTheBestPair) {
  const std::vector<ClassedBox> detections{{{0, 0, 10, 10}, 0}, {{4, 0, 14, 10}, 0}};
  const std::vector<ClassedBox> tracks{{{3, 0, 13, 10}, 0}, {{8, 0, 18, 10}, 0}};
  EXPECT_EQ(match_boxes(detections, tracks, 0.3), (std::vector<std::size_t>{0, 1}));
}

TEST(MatchBoxes, EqualsTryingEverything) {
  base::Random random(5, "match", 0);
  int with_shared = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const auto draw = [&](std::size_t count) {
      std::vector<ClassedBox> boxes;
      for (std::size_t i = 0; i < count; ++i) {
        const double x = 30 * random.uniform(), y = 30 * random.uniform();
        boxes.push_back({{x, y, x + 8 + 12 * random.uniform(), y + 8 + 12 * random.uniform()}, 0});
      }
      return boxes;
    };
    const auto detections = draw(1 + static_cast<std::size_t>(trial % 6)),
               tracks = draw(1 + static_cast<std::size_t>(trial % 5));
    std::vector<std::vector<double>> iou;
    for (const auto& d : detections) {
      auto& row = iou.emplace_back();
      for (const auto& t : tracks) row.push_back(cairn::testing::reference_iou(d.box, t.box));
    }
    const auto expected = cairn::testing::reference_match(iou, tracks.size(), 0.2);
    const auto found = match_boxes(detections, tracks, 0.2);
    for (std::size_t d = 0; d < detections.size(); ++d) {
      EXPECT_EQ(found[d] == kNoMatch ? -1 : static_cast<int>(found[d]), expected[d]) << "trial " << trial;
      with_shared += expected[d] >= 0 ? 1 : 0;
    }
  }
  EXPECT_GT(with_shared, 200);
}

}  // namespace
