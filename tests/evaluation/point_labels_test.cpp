#include "evaluation/point_labels.hpp"

#include <gtest/gtest.h>

#include "base/error.hpp"

namespace cairn::evaluation {
namespace {

constexpr std::uint32_t kNone = kNoInstance;

struct Points {
  std::vector<std::uint8_t> label, true_label;
  std::vector<std::uint32_t> instance, true_instance;

  void add(int count, std::uint8_t found, std::uint32_t found_id, std::uint8_t truth, std::uint32_t true_id) {
    for (int i = 0; i < count; ++i) {
      label.push_back(found);
      instance.push_back(found_id);
      true_label.push_back(truth);
      true_instance.push_back(true_id);
    }
  }
  [[nodiscard]] LabelPairs pairs() const { return {label, true_label, instance, true_instance}; }
};

TEST(PointLabels, OverlapOfRockCountsBasalContactAsRock) {
  Points p;
  p.add(60, 2, 7, 2, 1);  // both
  p.add(10, 4, 7, 2, 1);  // both: basal contact stands for rock
  p.add(10, 2, 7, 3, 1);  // found only: pedestal taken for rock
  p.add(20, 3, 7, 2, 1);  // true only
  p.add(100, 1, kNone, 1, kNone);
  const auto scores = score_labels(p.pairs());
  EXPECT_EQ(scores.rock.both, 70U);
  EXPECT_DOUBLE_EQ(*scores.rock.iou(), 0.7);
  EXPECT_DOUBLE_EQ(*scores.rock.dice(), 140.0 / 170.0);
  EXPECT_DOUBLE_EQ(*scores.rock.precision(), 70.0 / 80.0);
  EXPECT_DOUBLE_EQ(*scores.rock.recall(), 70.0 / 90.0);
  EXPECT_DOUBLE_EQ(*scores.classes[1].iou(), 1.0);
  EXPECT_FALSE(scores.classes[0].iou().has_value());
  ASSERT_EQ(scores.rocks.size(), 1U);
  EXPECT_EQ(scores.rocks[0].id, 7U);
  EXPECT_TRUE(scores.rocks[0].matched);
  EXPECT_DOUBLE_EQ(*scores.rocks[0].overlap.iou(), 0.7);
}

TEST(PointLabels, TwoRocksTakenForOneMatchAtMostOne) {
  Points p;
  p.add(60, 2, 5, 2, 1);
  p.add(40, 2, 5, 2, 2);
  p.add(30, 2, 6, 1, kNone);  // a rock where there is none
  const auto scores = score_labels(p.pairs());
  EXPECT_EQ(scores.found_rocks, 2U);
  EXPECT_EQ(scores.matched, 1U);
  EXPECT_TRUE(scores.rocks[0].matched);
  EXPECT_FALSE(scores.rocks[1].matched);
  EXPECT_DOUBLE_EQ(scores.precision(), 0.5);
  EXPECT_DOUBLE_EQ(scores.recall(), 0.5);
}

TEST(PointLabels, ARockCutInHalvesIsNotFoundTwice) {
  Points p;
  p.add(50, 2, 1, 2, 1);
  p.add(50, 2, 2, 2, 1);
  EXPECT_EQ(score_labels(p.pairs(), 0.5).matched, 1U);
  EXPECT_EQ(score_labels(p.pairs(), 0.51).matched, 0U);
  EXPECT_EQ(score_labels(p.pairs(), 0.51).rocks[0].id, 1U);
}

TEST(PointLabels, EmptyAndMismatchedInput) {
  EXPECT_FALSE(score_labels({}).rock.iou().has_value());
  EXPECT_EQ(score_labels({}).recall(), 0.0);
  Points p;
  p.add(3, 2, 1, 2, 1);
  p.label.pop_back();
  EXPECT_THROW((void)score_labels(p.pairs()), base::Error);
  EXPECT_THROW((void)score_labels({}, 0.0), base::Error);
}

}  // namespace
}  // namespace cairn::evaluation
