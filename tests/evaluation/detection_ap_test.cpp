#include "evaluation/detection_ap.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/random.hpp"

namespace cairn::evaluation {
namespace {

constexpr double kExact = 1e-12;

survey::Detection found(int image, double x, double score, const char* name = "rock") {
  survey::Detection d;
  d.frame = survey::FrameId(image);
  d.object_class = name;
  d.score = score;
  d.box = {x, 0, x + 10, 10};
  return d;
}

TrueRegion there(int image, double x, const char* name = "rock") {
  return {survey::FrameId(image), name, {x, 0, x + 10, 10}, false, false};
}

TEST(DetectionAp, PerfectDetectionsScoreOne) {
  const auto s = score_detections({found(1, 0, .9), found(2, 50, .8)}, {there(1, 0), there(2, 50)}, {});
  ASSERT_EQ(s.classes.size(), 1U);
  EXPECT_NEAR(s.classes[0].ap50_95(), 1.0, kExact);
  EXPECT_NEAR(s.classes[0].ap50_90(), 1.0, kExact);
  EXPECT_DOUBLE_EQ(*s.classes[0].recall(), 1.0);
}

// Two true boxes; in descending score: hit, miss, hit. Precision 1, 1/2, 2/3 at recall 1/2, 1/2, 1. Interpolated: 1 at
// the 51 recalls 0 .. 0.50, 2/3 at the other 50.
TEST(DetectionAp, HandComputedCurve) {
  const auto s =
      score_detections({found(1, 0, .9), found(1, 300, .8), found(2, 0, .7)}, {there(1, 0), there(2, 0)}, {});
  EXPECT_NEAR(s.classes[0].ap50(), (51.0 + 50.0 * 2.0 / 3.0) / 101.0, kExact);
  EXPECT_EQ(s.classes[0].tp, 2U);
  EXPECT_EQ(s.classes[0].fp, 1U);
  EXPECT_EQ(s.classes[0].fn, 0U);
}

// Shifted by 2 of 10 px: IoU 80/120 = 0.667 counts at .50 .. .65, four of ten thresholds, and of nine.
TEST(DetectionAp, ThresholdsOfCocoAndOfFiftyToNinety) {
  const auto s = score_detections({found(1, 2, .9)}, {there(1, 0)}, {});
  EXPECT_NEAR(s.classes[0].ap50(), 1.0, kExact);
  EXPECT_NEAR(s.classes[0].ap75(), 0.0, kExact);
  EXPECT_NEAR(s.classes[0].ap50_95(), 0.4, kExact);
  EXPECT_NEAR(s.classes[0].ap50_90(), 4.0 / 9.0, kExact);
}

TEST(DetectionAp, ASecondBoxOnOneObjectIsFalse) {
  const auto s = score_detections({found(1, 0, .9), found(1, 0, .8)}, {there(1, 0)}, {});
  EXPECT_EQ(s.classes[0].tp, 1U);
  EXPECT_EQ(s.classes[0].fp, 1U);
  EXPECT_NEAR(s.classes[0].ap50(), 1.0, kExact);  // the false one comes after full recall
}

TEST(DetectionAp, IgnoredAndCrowdRegions) {
  auto ignored = there(1, 100);
  ignored.ignored = true;
  TrueRegion crowd{survey::FrameId(1), "rock", {200, 0, 400, 10}, true, true};
  const std::vector<survey::Detection> detections{found(1, 100, .9), found(1, 210, .8), found(1, 250, .7),
                                                  found(1, 0, .6)};
  const auto s = score_detections(detections, {ignored, crowd, there(1, 0)}, {});
  EXPECT_EQ(s.classes[0].truths, 1U);
  EXPECT_EQ(s.classes[0].tp, 1U);
  EXPECT_EQ(s.classes[0].fp, 0U);  // one on the ignored box, two inside the crowd: none of them counts
  EXPECT_NEAR(s.classes[0].ap50_95(), 1.0, kExact);
  // A second box on an ignored object that is no crowd is false.
  const auto twice = score_detections({found(1, 100, .9), found(1, 100, .8)}, {ignored, there(1, 0)}, {});
  EXPECT_EQ(twice.classes[0].fp, 1U);
}

TEST(DetectionAp, AFreeTrueBoxGoesBeforeABetterIgnoredOne) {
  auto ignored = there(1, 0);
  ignored.ignored = true;
  const auto s = score_detections({found(1, 0, .9)}, {ignored, there(1, 2)}, {});
  EXPECT_EQ(s.classes[0].tp, 1U);
}

TEST(DetectionAp, OnlyTheBestHundredOfAnImageCount) {
  std::vector<survey::Detection> detections;
  for (int i = 0; i < 100; ++i) detections.push_back(found(1, 1000 + 20 * i, .9));
  detections.push_back(found(1, 0, .1));
  EXPECT_NEAR(score_detections(detections, {there(1, 0)}, {}).classes[0].ap50(), 0.0, kExact);
  EXPECT_NEAR(score_detections(detections, {there(1, 0)}, {.max_detections = 101}).classes[0].ap50(), 1.0 / 101.0,
              kExact);
}

TEST(DetectionAp, MeanLeavesOutClassesWithoutTruth) {
  const auto s = score_detections({found(1, 0, .9), found(1, 50, .9, "tree")}, {there(1, 0), there(1, 90, "cone")}, {});
  ASSERT_EQ(s.classes.size(), 3U);  // cone, rock, tree
  EXPECT_EQ(s.classes[2].truths, 0U);
  EXPECT_NEAR(*s.mean(&ClassAp::ap50), 0.5, kExact);
  EXPECT_FALSE(score_detections({found(1, 0, .9)}, {}, {}).mean(&ClassAp::ap50).has_value());
  EXPECT_FALSE(score_detections({}, {}, {}).mean(&ClassAp::ap50).has_value());
}

TEST(DetectionAp, TiesKeepTheOrderGiven) {
  const auto hit_first = score_detections({found(1, 0, .5), found(1, 300, .5)}, {there(1, 0)}, {});
  const auto miss_first = score_detections({found(1, 300, .5), found(1, 0, .5)}, {there(1, 0)}, {});
  EXPECT_NEAR(hit_first.classes[0].ap50(), 1.0, kExact);
  EXPECT_NEAR(miss_first.classes[0].ap50(), 0.5, kExact);
}

TEST(DetectionAp, MinScoreBearsOnPrecisionAndRecallOnly) {
  const auto s = score_detections({found(1, 0, .3), found(1, 300, .2)}, {there(1, 0)}, {.min_score = 0.25});
  EXPECT_EQ(s.classes[0].fp, 0U);
  EXPECT_EQ(s.classes[0].tp, 1U);
  EXPECT_NEAR(s.classes[0].ap50(), 1.0, kExact);
  EXPECT_EQ(score_detections({found(1, 0, .3)}, {there(1, 0)}, {.min_score = 0.5}).classes[0].fn, 1U);
}

// The definition written out naively: for each recall step the best precision at any cut of the sorted list whose
// recall reaches it, every cut counted anew.
double slow_ap(std::vector<survey::Detection> detections, const std::vector<TrueRegion>& truth, double threshold) {
  std::stable_sort(detections.begin(), detections.end(),
                   [](const auto& a, const auto& b) { return a.score > b.score; });
  std::vector<int> verdicts;
  std::set<std::size_t> taken;
  for (const auto& d : detections) {
    double best = threshold;
    std::size_t at = truth.size();
    for (std::size_t t = 0; t < truth.size(); ++t) {
      if (truth[t].image != d.frame || taken.contains(t)) continue;
      const double w = std::min(d.box.xmax, truth[t].box.xmax) - std::max(d.box.xmin, truth[t].box.xmin);
      const double both = w > 0 ? w * 10.0 : 0.0;
      const double overlap = both / (200.0 - both);
      if (overlap >= best) {
        best = overlap;
        at = t;
      }
    }
    if (at < truth.size()) taken.insert(at);
    verdicts.push_back(at < truth.size() ? 1 : 0);
  }
  double sum = 0.0;
  for (int step = 0; step <= 100; ++step) {
    double best = 0.0;
    for (std::size_t cut = 1; cut <= verdicts.size(); ++cut) {
      const auto hits =
          static_cast<double>(std::count(verdicts.begin(), verdicts.begin() + static_cast<std::ptrdiff_t>(cut), 1));
      if (hits / static_cast<double>(truth.size()) >= 0.01 * step)
        best = std::max(best, hits / static_cast<double>(cut));
    }
    sum += best;
  }
  return sum / 101.0;
}

TEST(DetectionAp, AgreesWithTheSlowDefinition) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    base::Random random(seed, "boxes", 0);
    std::vector<survey::Detection> detections;
    std::vector<TrueRegion> truth;
    for (int image = 0; image < 6; ++image)
      for (int k = 0; k < 8; ++k) {
        const double x = 14.0 * k + random.uniform(-3, 3);
        if (random.uniform() < 0.7) truth.push_back(there(image, x));
        // Scores in steps, so that ties occur; a second box now and then.
        while (random.uniform() < 0.6)
          detections.push_back(found(image, x + 1.5 * random.normal(), 0.1 * static_cast<double>(random.below(10))));
      }
    const auto s = score_detections(detections, truth, {});
    for (std::size_t k = 0; k < kIouThresholds; ++k)
      EXPECT_NEAR(s.classes[0].ap[k], slow_ap(detections, truth, iou_threshold(k)), 1e-12) << seed << " " << k;
    EXPECT_GT(s.classes[0].ap50(), 0.2);
    EXPECT_LT(s.classes[0].ap50(), 1.0);
  }
}

}  // namespace
}  // namespace cairn::evaluation
