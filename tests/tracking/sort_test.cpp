#include "tracking/sort.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "base/error.hpp"
#include "base/random.hpp"
#include "tracking/reference_sort.hpp"

namespace {

using namespace cairn;
using geometry::PixelBox;
using tracking::BoxObservation;
using tracking::SortOptions;
using tracking::SortTracker;

constexpr double kSamePx = 1e-8;

PixelBox square(double x, double y, double side) {
  return {x, y, x + side, y + side};
}

SortOptions options(std::int64_t min_hits, std::int64_t max_age) {
  SortOptions o;
  o.min_hits = min_hits;
  o.max_age = max_age;
  return o;
}

// Walkers that cross, with jitter, misses and false boxes.
std::vector<std::vector<PixelBox>> crossing_walkers(int frames) {
  base::Random random(11, "walkers", 0);
  std::vector<std::vector<PixelBox>> result;
  for (int f = 0; f < frames; ++f) {
    auto& boxes = result.emplace_back();
    for (int w = 0; w < 5; ++w) {
      if (random.uniform() < 0.15) continue;
      const double x = w % 2 == 0 ? 20 + 6 * f + 15 * w : 500 - 5 * f - 20 * w;
      const double y = 100 + 12 * w + 2 * random.normal();
      const double width = 40 + 2 * random.normal(), height = 80 + 3 * random.normal();
      boxes.push_back({x + random.normal(), y, x + random.normal() + width, y + height});
    }
    if (random.uniform() < 0.2) boxes.push_back(square(600 * random.uniform(), 300 * random.uniform(), 30));
  }
  return result;
}

TEST(Sort, EqualsTheEquationsWrittenDownPlainly) {
  for (const auto& [min_hits, max_age] : {std::pair{3, 1}, std::pair{1, 3}, std::pair{0, 1}, std::pair{5, 8}}) {
    const auto frames = crossing_walkers(120);
    const auto expected = cairn::testing::reference_sort(frames, min_hits, max_age, 0.3);
    SortOptions o = options(min_hits, max_age);
    o.ids = "all";
    SortTracker tracker(o);
    std::size_t at = 0;
    int number = 0;
    for (const auto& boxes : frames) {
      ++number;
      std::vector<BoxObservation> observations;
      for (const auto& b : boxes) observations.push_back({b, 0, 0.5});
      for (const auto& row : tracker.step(observations)) {
        ASSERT_LT(at, expected.size());
        EXPECT_EQ(expected[at].frame, number);
        EXPECT_EQ(expected[at].id, row.id);
        EXPECT_NEAR(expected[at].box.xmin, row.box.xmin, kSamePx);
        EXPECT_NEAR(expected[at].box.ymin, row.box.ymin, kSamePx);
        EXPECT_NEAR(expected[at].box.xmax, row.box.xmax, kSamePx);
        EXPECT_NEAR(expected[at].box.ymax, row.box.ymax, kSamePx);
        ++at;
      }
    }
    EXPECT_EQ(at, expected.size());
    EXPECT_GT(at, 200U);
  }
}

// A still box in frames 1..n: in which frames is it emitted?
std::set<int> emitted_frames(SortTracker& tracker, const std::vector<bool>& shown) {
  std::set<int> frames;
  const BoxObservation o{square(10, 10, 20), 0, 0.5};
  for (std::size_t f = 0; f < shown.size(); ++f)
    if (!tracker.step(shown[f] ? std::span(&o, 1) : std::span<const BoxObservation>()).empty())
      frames.insert(static_cast<int>(f) + 1);
  return frames;
}

TEST(Sort, MinHitsMatchesFollowTheFirstBox) {
  SortOptions o = options(3, 1);
  // Frame 1 is empty, so the early rule ends before the track is old enough.
  SortTracker tracker(o);
  EXPECT_EQ(emitted_frames(tracker, {false, true, true, true, true, true}), (std::set<int>{2, 3, 5, 6}));
  o.early = false;
  SortTracker late(o);
  EXPECT_EQ(emitted_frames(late, {false, true, true, true, true, true}), (std::set<int>{5, 6}));
}

TEST(Sort, AMissBreaksTheStreakUnlessKept) {
  SortOptions o = options(2, 5);
  o.early = false;
  const std::vector<bool> shown{true, true, true, false, true, true, true};
  // Found again at once, but two matches without a gap are wanted before the next row.
  SortTracker reset(o);
  EXPECT_EQ(emitted_frames(reset, shown), (std::set<int>{3, 6, 7}));
  o.streak = "keep";
  SortTracker keep(o);
  EXPECT_EQ(emitted_frames(keep, shown), (std::set<int>{3, 5, 6, 7}));
}

TEST(Sort, EmitAgeAndKeepAgeAreApart) {
  SortOptions o = options(1, 5);
  o.early = false;
  o.streak = "keep";
  o.emit_age = 2;
  SortTracker tracker(o);
  const BoxObservation box{square(10, 10, 20), 3, 0.75};
  const auto with = std::span(&box, 1);
  tracker.step(with);
  EXPECT_FALSE(tracker.step(with)[0].coasted());
  for (int miss = 1; miss <= 4; ++miss) {
    const auto rows = tracker.step({});
    ASSERT_EQ(rows.size(), miss <= 2 ? 1U : 0U) << miss;
    if (miss > 2) continue;
    EXPECT_TRUE(rows[0].coasted());
    EXPECT_EQ(rows[0].object_class, 3);
    EXPECT_EQ(rows[0].score, 0.75);
  }
  // Kept for five: the same identity returns.
  const auto back = tracker.step(with);
  ASSERT_EQ(back.size(), 1U);
  EXPECT_EQ(back[0].id, 1);
  for (int miss = 1; miss <= 5; ++miss) tracker.step({});
  EXPECT_FALSE(tracker.idle());
  tracker.step({});
  EXPECT_TRUE(tracker.idle());
}

TEST(Sort, PaperPresetRegistersAfterTenAndCoastsForNinetyNine) {
  SortOptions o;
  o.preset = "paper";
  o.early = false;
  SortTracker tracker(o);
  const BoxObservation box{square(10, 10, 20), 0, 1.0};
  for (int f = 1; f <= 10; ++f) EXPECT_TRUE(tracker.step(std::span(&box, 1)).empty()) << f;
  EXPECT_EQ(tracker.step(std::span(&box, 1)).size(), 1U);
  for (int miss = 1; miss <= 99; ++miss) {
    const auto rows = tracker.step({});
    ASSERT_EQ(rows.size(), 1U) << miss;
    EXPECT_TRUE(rows[0].coasted());
  }
  EXPECT_TRUE(tracker.step({}).empty());
  EXPECT_FALSE(tracker.idle());
  tracker.step({});
  EXPECT_TRUE(tracker.idle());
}

TEST(Sort, ConfirmedIdentitiesHaveNoGaps) {
  SortOptions o = options(2, 1);
  SortTracker tracker(o);
  base::Random random(2, "gaps", 0);
  std::set<std::int64_t> seen;
  const BoxObservation still{square(10, 10, 20), 0, 1.0};
  for (int f = 0; f < 60; ++f) {
    std::vector<BoxObservation> boxes{still};
    if (f >= 3) boxes.push_back({square(100 + 40 * f, 50, 10), 0, 1.0});  // false, never matched
    if (f >= 30) boxes.push_back({square(300, 300, 30), 0, 1.0});
    for (const auto& row : tracker.step(boxes)) seen.insert(row.id);
  }
  EXPECT_EQ(seen, (std::set<std::int64_t>{1, 2}));
  EXPECT_EQ(tracker.tracks_emitted(), 2);
  EXPECT_GT(tracker.tracks_started(), 50);
}

TEST(Sort, ClassesKeepTracksApart) {
  for (const bool aware : {true, false}) {
    SortOptions o = options(0, 1);
    o.class_aware = aware;
    SortTracker tracker(o);
    const BoxObservation rock{square(10, 10, 20), 0, 1.0}, tree{square(10, 10, 20), 1, 1.0};
    tracker.step(std::span(&rock, 1));
    EXPECT_EQ(tracker.step(std::span(&tree, 1))[0].id, aware ? 2 : 1);
  }
}

// A box that moves 30 px a second, seen at 10 Hz, then missing for 2 s: with real time steps the prediction is 60 px on
// and matches; with steps of 1 it stays behind.
TEST(Sort, RealTimeStepsBridgeAnUnevenRate) {
  for (const bool real : {true, false}) {
    SortTracker tracker(options(0, 3));
    const auto at = [](double seconds) { return BoxObservation{square(100 + 30 * seconds, 100, 40), 0, 1.0}; };
    for (int k = 0; k < 30; ++k) {
      const auto box = at(0.1 * k);
      tracker.step(std::span(&box, 1), 1.0);
    }
    const auto later = at(2.9 + 2.0);
    const auto rows = tracker.step(std::span(&later, 1), real ? 20.0 : 1.0);
    ASSERT_EQ(rows.size(), 1U);
    EXPECT_EQ(rows[0].id, real ? 1 : 2);
  }
}

TEST(Sort, FramesWithoutTracksCanBeSkipped) {
  SortOptions o = options(3, 1);
  SortTracker one(o), two(o);
  const BoxObservation box{square(10, 10, 20), 0, 1.0};
  for (int k = 0; k < 5; ++k) one.step({});
  two.skip_frames(5);
  EXPECT_EQ(one.step(std::span(&box, 1)).size(), two.step(std::span(&box, 1)).size());
  EXPECT_THROW(two.skip_frames(1), base::Error);
}

TEST(Sort, NothingThatIsNotFiniteComesOut) {
  SortOptions o = options(0, 30);
  o.emit_age = 30;
  SortTracker tracker(o);
  base::Random random(9, "wild", 0);
  for (int f = 0; f < 400; ++f) {
    std::vector<BoxObservation> boxes;
    for (int i = 0; i < 3; ++i) {
      const double scale = std::pow(10.0, 8 * random.uniform() - 2);
      const double x = random.normal(), y = random.normal();
      boxes.push_back({{x, y, x + scale, y + scale * std::pow(10.0, 2 * random.normal())}, 0, 1.0});
    }
    for (const auto& row : tracker.step(boxes))
      for (const double side : {row.box.xmin, row.box.ymin, row.box.xmax, row.box.ymax})
        ASSERT_TRUE(std::isfinite(side));
  }
}

}  // namespace
