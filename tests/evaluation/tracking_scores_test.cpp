#include "evaluation/tracking_scores.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "base/error.hpp"
#include "base/random.hpp"
#include "evaluation/box_overlap.hpp"

namespace cairn::evaluation {
namespace {

constexpr double kExact = 1e-12;

// A box of 10 x 10 px whose left edge is at x.
geometry::PixelBox at(double x) {
  return {x, 0, x + 10, 10};
}

TEST(BoxOverlap, KnownValues) {
  EXPECT_DOUBLE_EQ(iou(at(0), at(0)), 1.0);
  EXPECT_DOUBLE_EQ(iou(at(0), at(5)), 50.0 / 150.0);
  EXPECT_DOUBLE_EQ(iou(at(0), at(10)), 0.0);
  EXPECT_DOUBLE_EQ(iou({3, 3, 3, 3}, {3, 3, 3, 3}), 0.0);
}

TEST(Tracking, PerfectTracksScoreOne) {
  std::vector<TrueBox> truth;
  std::vector<IdentifiedBox> tracks;
  for (int f = 1; f <= 5; ++f)
    for (int k = 0; k < 3; ++k) {
      truth.push_back({f, k, at(100.0 * k + f), false});
      tracks.push_back({f, 70 - k, at(100.0 * k + f)});
    }
  const auto s = make_sequence(truth, tracks);
  EXPECT_DOUBLE_EQ(clear_score(s).mota(), 1.0);
  EXPECT_DOUBLE_EQ(clear_score(s).motp(), 1.0);
  EXPECT_EQ(clear_score(s).mostly_tracked, 3U);
  EXPECT_DOUBLE_EQ(identity_score(s).idf1(), 1.0);
  EXPECT_NEAR(hota_score(s).hota(), 1.0, kExact);
}

// One object over ten frames; track 1 follows it in frames 1-4, nothing in 5-6, track 2 in 7-10; one false box.
TEST(Tracking, HandComputedSwitchAndFragmentation) {
  std::vector<TrueBox> truth;
  std::vector<IdentifiedBox> tracks;
  for (int f = 1; f <= 10; ++f) {
    truth.push_back({f, 1, at(f), false});
    if (f <= 4) tracks.push_back({f, 1, at(f)});
    if (f >= 7) tracks.push_back({f, 2, at(f)});
  }
  tracks.push_back({3, 9, at(500)});
  const auto s = make_sequence(truth, tracks);
  const auto c = clear_score(s);
  EXPECT_EQ(c.tp, 8U);
  EXPECT_EQ(c.fn, 2U);
  EXPECT_EQ(c.fp, 1U);
  EXPECT_EQ(c.id_switches, 1U);
  // As in TrackEval, frames 5 and 6 (no track at all) do not break the run.
  EXPECT_EQ(c.fragmentations, 0U);
  EXPECT_EQ(c.mostly_tracked, 0U);  // 8 of 10 is not more than 80 %
  EXPECT_EQ(c.mostly_lost, 0U);
  EXPECT_DOUBLE_EQ(c.mota(), 1.0 - 4.0 / 10.0);
  const auto i = identity_score(s);
  EXPECT_EQ(i.idtp, 4U);
  EXPECT_EQ(i.idfn, 6U);
  EXPECT_EQ(i.idfp, 5U);
  EXPECT_DOUBLE_EQ(i.idf1(), 8.0 / 19.0);
  const auto h = hota_score(s);
  // DetA = 8 / 11; each of the 8 has TPA 4, and 10 + 4 - 4 = 10 in its union: AssA = 0.4; the same at every alpha.
  EXPECT_NEAR(h.det_a(), 8.0 / 11.0, kExact);
  EXPECT_NEAR(h.ass_a(), 0.4, kExact);
  EXPECT_NEAR(h.hota(), std::sqrt(8.0 / 11.0 * 0.4), kExact);
  EXPECT_NEAR(h.loc_a(), 1.0, kExact);
}

TEST(Tracking, ARunThatBreaksBesideAnotherTrackIsAFragmentation) {
  std::vector<TrueBox> truth;
  std::vector<IdentifiedBox> tracks;
  for (int f = 1; f <= 3; ++f) {
    truth.push_back({f, 1, at(0), false});
    if (f != 2) tracks.push_back({f, 1, at(0)});
    tracks.push_back({f, 2, at(900)});
  }
  EXPECT_EQ(clear_score(make_sequence(truth, tracks)).fragmentations, 1U);
}

// A track that was matched before keeps its object though another overlaps it better.
TEST(Tracking, ThePairOfTheFrameBeforeIsKept) {
  const std::vector<TrueBox> truth{{1, 1, at(0), false}, {2, 1, at(0), false}};
  const std::vector<IdentifiedBox> tracks{{1, 1, at(0)}, {2, 1, at(2)}, {2, 2, at(0)}};
  const auto c = clear_score(make_sequence(truth, tracks));
  EXPECT_EQ(c.id_switches, 0U);
  EXPECT_DOUBLE_EQ(c.overlap_sum, 1.0 + 80.0 / 120.0);
  // Where the overlap has fallen below the threshold it is not.
  const std::vector<IdentifiedBox> gone{{1, 1, at(0)}, {2, 1, at(4)}, {2, 2, at(0)}};
  EXPECT_EQ(clear_score(make_sequence(truth, gone)).id_switches, 1U);
}

TEST(Tracking, AnOverlapOfTheThresholdItselfMatches) {
  // 10 x 10 inside 10 x 20: exactly one half.
  const std::vector<TrueBox> truth{{1, 1, {0, 0, 10, 20}, false}};
  const std::vector<IdentifiedBox> tracks{{1, 1, {0, 0, 10, 10}}};
  const auto s = make_sequence(truth, tracks);
  EXPECT_EQ(clear_score(s).tp, 1U);
  EXPECT_EQ(identity_score(s).idtp, 1U);
  EXPECT_EQ(hota_score(s).alphas[9].tp, 1U);   // alpha .50
  EXPECT_EQ(hota_score(s).alphas[10].tp, 0U);  // alpha .55
}

TEST(Tracking, IgnoredTruthIsNeitherMissedNorFound) {
  const std::vector<TrueBox> truth{{1, 1, at(0), false}, {1, 2, at(100), true}, {1, 3, at(200), true}};
  const std::vector<IdentifiedBox> tracks{{1, 1, at(0)}, {1, 2, at(100)}, {1, 3, at(400)}};
  const auto s = make_sequence(truth, tracks);
  EXPECT_EQ(s.ignored_truths, 2U);
  EXPECT_EQ(s.ignored_tracks, 1U);
  const auto c = clear_score(s);
  EXPECT_EQ(c.truths, 1U);
  EXPECT_EQ(c.fp, 1U);
  EXPECT_EQ(c.fn, 0U);
}

TEST(Tracking, NothingAgainstSomething) {
  const auto none = make_sequence({{1, 1, at(0), false}, {2, 1, at(0), false}}, {});
  EXPECT_DOUBLE_EQ(clear_score(none).mota(), 0.0);
  EXPECT_EQ(clear_score(none).mostly_lost, 1U);
  EXPECT_DOUBLE_EQ(identity_score(none).idf1(), 0.0);
  EXPECT_DOUBLE_EQ(hota_score(none).hota(), 0.0);
  const auto only_tracks = make_sequence({}, {{1, 1, at(0)}});
  EXPECT_EQ(clear_score(only_tracks).fp, 1U);
  EXPECT_EQ(identity_score(only_tracks).idfp, 1U);
  const auto empty = make_sequence({}, {});
  EXPECT_DOUBLE_EQ(clear_score(empty).mota(), 0.0);
  EXPECT_DOUBLE_EQ(hota_score(empty).hota(), 0.0);
}

TEST(Tracking, RefusesTwoBoxesOfOneIdentityInAFrame) {
  EXPECT_THROW(static_cast<void>(make_sequence({{1, 1, at(0), false}, {1, 1, at(9), false}}, {})), base::Error);
  EXPECT_THROW(static_cast<void>(make_sequence({}, {{1, 1, at(0)}, {1, 1, at(9)}})), base::Error);
}

// Random small sequences: identities by trying every assignment, and HOTA written out detection by detection.
class Oracle : public ::testing::TestWithParam<std::uint64_t> {
 protected:
  void SetUp() override {
    base::Random random(GetParam(), "tracks", 0);
    for (int f = 0; f < 8; ++f) {
      for (int k = 0; k < 4; ++k) {
        const double x = 12.0 * k + random.uniform(-6, 6);
        if (random.uniform() < 0.8) truth_.push_back({f, k, at(x), false});
        const int id = random.uniform() < 0.75 ? k : 3 - k + 4;
        const IdentifiedBox box{f, id, at(x + random.uniform(-6, 6))};
        const bool repeated = std::any_of(tracks_.begin(), tracks_.end(),
                                          [&](const auto& t) { return t.frame == box.frame && t.id == box.id; });
        if (random.uniform() < 0.8 && !repeated) tracks_.push_back(box);
      }
    }
  }
  std::vector<TrueBox> truth_;
  std::vector<IdentifiedBox> tracks_;
};

TEST_P(Oracle, IdentityByTryingEveryAssignment) {
  std::map<std::pair<std::int64_t, std::int64_t>, std::size_t> overlaps;
  for (const auto& t : truth_)
    for (const auto& k : tracks_)
      if (t.frame == k.frame && iou(t.box, k.box) >= 0.5) ++overlaps[{t.id, k.id}];
  std::vector<std::int64_t> ids{0, 1, 2, 3, 4, 5, 6, 7};
  std::size_t best = 0;
  do {
    std::size_t sum = 0;
    for (std::int64_t t = 0; t < 4; ++t) {
      const auto found = overlaps.find({t, ids[static_cast<std::size_t>(t)]});
      if (found != overlaps.end()) sum += found->second;
    }
    best = std::max(best, sum);
  } while (std::next_permutation(ids.begin(), ids.end()));
  const auto score = identity_score(make_sequence(truth_, tracks_));
  EXPECT_EQ(score.idtp, best);
  EXPECT_EQ(score.idtp + score.idfn, truth_.size());
  EXPECT_EQ(score.idtp + score.idfp, tracks_.size());
}

TEST_P(Oracle, HotaDetectionByDetection) {
  // The score that a pair of identities has before unique matching.
  const auto count = [](const auto& boxes, std::int64_t id) {
    return static_cast<double>(std::count_if(boxes.begin(), boxes.end(), [&](const auto& b) { return b.id == id; }));
  };
  std::map<std::pair<std::int64_t, std::int64_t>, double> potential;
  for (const auto& t : truth_)
    for (const auto& k : tracks_) {
      if (t.frame != k.frame || iou(t.box, k.box) == 0.0) continue;
      double competing = -iou(t.box, k.box);
      for (const auto& other : tracks_)
        if (other.frame == t.frame) competing += iou(t.box, other.box);
      for (const auto& other : truth_)
        if (other.frame == t.frame) competing += iou(other.box, k.box);
      potential[{t.id, k.id}] += iou(t.box, k.box) / competing;
    }
  const auto score = hota_score(make_sequence(truth_, tracks_));
  // Best matching of each frame by trying all.
  std::vector<std::pair<const TrueBox*, const IdentifiedBox*>> matched;
  for (int f = 0; f < 8; ++f) {
    std::vector<const TrueBox*> rows;
    std::vector<const IdentifiedBox*> columns;
    for (const auto& t : truth_)
      if (t.frame == f) rows.push_back(&t);
    for (const auto& k : tracks_)
      if (k.frame == f) columns.push_back(&k);
    while (columns.size() < rows.size()) columns.push_back(nullptr);
    std::sort(columns.begin(), columns.end());
    double best = -1.0;
    std::vector<const IdentifiedBox*> chosen;
    do {
      double sum = 0.0;
      for (std::size_t i = 0; i < rows.size(); ++i) {
        if (columns[i] == nullptr) continue;
        const double p = potential[{rows[i]->id, columns[i]->id}];
        const double whole = count(truth_, rows[i]->id) + count(tracks_, columns[i]->id) - p;
        sum += p / whole * iou(rows[i]->box, columns[i]->box);
      }
      if (sum > best + 1e-12) {
        best = sum;
        chosen = columns;
      }
    } while (std::next_permutation(columns.begin(), columns.end()));
    for (std::size_t i = 0; i < rows.size(); ++i)
      if (chosen[i] != nullptr) matched.emplace_back(rows[i], chosen[i]);
  }
  double sum = 0.0;
  for (int step = 1; step <= 19; ++step) {
    const double alpha = 0.05 * step - 1e-12;
    std::map<std::pair<std::int64_t, std::int64_t>, double> together;
    double tp = 0.0;
    for (const auto& [t, k] : matched)
      if (iou(t->box, k->box) >= alpha) {
        ++together[{t->id, k->id}];
        ++tp;
      }
    double association = 0.0;
    for (const auto& [t, k] : matched) {
      if (iou(t->box, k->box) < alpha) continue;
      const double tpa = together[{t->id, k->id}];
      association += tpa / (count(truth_, t->id) + count(tracks_, k->id) - tpa);
    }
    const double fn = static_cast<double>(truth_.size()) - tp, fp = static_cast<double>(tracks_.size()) - tp;
    if (tp > 0.0) sum += std::sqrt(tp / (tp + fn + fp) * association / tp);
    EXPECT_EQ(static_cast<double>(score.alphas[static_cast<std::size_t>(step) - 1].tp), tp) << step;
  }
  EXPECT_NEAR(score.hota(), sum / 19.0, 1e-9);
}

TEST_P(Oracle, ScoresDoNotHangOnTheOrderOfTheBoxes) {
  const auto first = make_sequence(truth_, tracks_);
  std::reverse(truth_.begin(), truth_.end());
  std::reverse(tracks_.begin(), tracks_.end());
  const auto second = make_sequence(truth_, tracks_);
  EXPECT_EQ(clear_score(first).id_switches, clear_score(second).id_switches);
  EXPECT_NEAR(clear_score(first).overlap_sum, clear_score(second).overlap_sum, 1e-9);
  EXPECT_NEAR(hota_score(first).hota(), hota_score(second).hota(), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Seeds, Oracle, ::testing::Range<std::uint64_t>(1, 13));

TEST(Tracking, SequencesAreCombinedByTheirCounts) {
  const std::vector<TrueBox> truth{{1, 1, at(0), false}, {2, 1, at(0), false}};
  const auto all = make_sequence(truth, {{1, 1, at(0)}, {2, 1, at(0)}});
  const auto half = make_sequence(truth, {{1, 1, at(0)}});
  ClearScore c = clear_score(all);
  add(c, clear_score(half));
  EXPECT_DOUBLE_EQ(c.mota(), 0.75);
  EXPECT_EQ(c.objects, 2U);
  IdentityScore i = identity_score(all);
  add(i, identity_score(half));
  EXPECT_DOUBLE_EQ(i.idf1(), 6.0 / 7.0);
  HotaScore h = hota_score(all);
  add(h, hota_score(half));
  // AssA: two detections with 1, one with 1/2.
  EXPECT_NEAR(h.ass_a(), 2.5 / 3.0, kExact);
  EXPECT_NEAR(h.det_a(), 0.75, kExact);
}

}  // namespace
}  // namespace cairn::evaluation
