// The recorded survey: 18 photos, 7 s and 13 m apart, detections of boulders, trees, cars, benches, tables.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "localisation/locate.hpp"
#include "support/brighton_boxes.hpp"

namespace cairn::localisation {
namespace {

using geometry::Vec3;
using survey::TargetState;
using testing::BoxedSurvey;

constexpr double kFound = 1.5;  // m: a target of the same class this near counts as the object

struct Score {
  std::size_t wanted = 0, found = 0;  // objects.csv, shown in at least 3 photos
  double median_m = 0.0, p95_m = 0.0;
  std::size_t converged = 0;  // targets with at least three boxes that are reported as converged
  std::size_t unmatched = 0;  // of these, those near no object of objects.csv
  std::size_t impure = 0;     // of these, those whose boxes are not mostly of one labelled object
  std::size_t doubles = 0;    // further targets of an object that has one already
  std::vector<double> errors;
};

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return std::numeric_limits<double>::infinity();
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::floor(q * static_cast<double>(values.size() - 1) + 0.5))];
}

Score score(const BoxedSurvey& boxed, std::uint64_t seed) {
  base::RunContext ctx;
  ctx.seed = seed;
  const auto result = locate(boxed.survey, {}, ctx);
  Score s;
  std::map<std::string, std::set<std::int64_t>> photos;
  for (std::size_t i = 0; i < boxed.object_of.size(); ++i)
    if (!boxed.object_of[i].empty()) photos[boxed.object_of[i]].insert(boxed.survey.detections[i].frame.value);
  std::set<std::size_t> matched;
  for (const auto& row : testing::brighton_objects()) {
    const Vec3 at(std::stod(row.at("east_m")), std::stod(row.at("north_m")), std::stod(row.at("up_m")));
    double best = kFound;
    for (std::size_t t = 0; t < result.targets.size(); ++t) {
      const auto& target = result.targets[t];
      if (target.state != TargetState::converged || target.object_class != row.at("class")) continue;
      const double distance = (target.centre - at).head<2>().norm();
      if (distance > kFound) continue;
      best = std::min(best, distance);
      matched.insert(t);
    }
    if (photos[row.at("object_id")].size() < 3) continue;
    ++s.wanted;
    if (best < kFound) s.errors.push_back(best);
  }
  s.found = s.errors.size();
  s.median_m = quantile(s.errors, 0.5);
  s.p95_m = quantile(s.errors, 0.95);
  std::set<std::string> owned;
  for (std::size_t t = 0; t < result.targets.size(); ++t) {
    const auto& target = result.targets[t];
    if (target.state != TargetState::converged) continue;
    ++s.converged;
    if (!matched.contains(t)) ++s.unmatched;
    std::map<std::string, std::size_t> votes;
    for (const auto id : target.detections) {
      const auto& object = boxed.object_of[static_cast<std::size_t>(id.value) - 1];
      if (!object.empty()) ++votes[object];
    }
    const auto best =
        std::max_element(votes.begin(), votes.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    if (best == votes.end() || 2 * best->second <= target.detections.size()) ++s.impure;
    else if (!owned.insert(best->first).second) ++s.doubles;
  }
  return s;
}

// The limits of the project: >= 95 % found, horizontal error median <= 0.10 m, 95 % <= 0.30 m. Plain triangulation of
// the same boxes reaches 0.02 and 0.06 m; held here to 0.04 and 0.15 m.
TEST(BrightonBeach, LocatesTheObjects) {
  for (const double scaled : {1.0, 0.4}) {
    const auto boxed = testing::brighton_detections(scaled);
    const Score s = score(boxed, 0);
    RecordProperty("found", static_cast<int>(s.found));
    EXPECT_EQ(s.wanted, 37U);
    EXPECT_GE(s.found, 36U) << scaled;  // 97.3 %
    EXPECT_LE(s.median_m, 0.04) << scaled;
    EXPECT_LE(s.p95_m, 0.15) << scaled;
    EXPECT_EQ(s.doubles, 0U);
    // A third of the objects (21 of 63) is neither in objects.csv nor in labels.csv: their targets match nothing there.
    EXPECT_LE(s.unmatched, 21U) << scaled;
  }
}

// The random draws of the filter must not decide what is found.
TEST(BrightonBeach, DoesNotHangOnASeed) {
  const auto boxed = testing::brighton_detections();
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Score s = score(boxed, seed);
    EXPECT_GE(s.found, 36U) << seed;
    EXPECT_LE(s.unmatched, 21U) << seed;
    EXPECT_LE(s.p95_m, 0.15) << seed;
  }
}

struct Pooled {
  double wanted = 0, found = 0, converged = 0, wrong = 0;
  std::vector<double> errors;
};

Pooled pooled(const testing::BoxNoise& noise) {
  Pooled sum;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Score s = score(testing::brighton_noisy(noise, seed), seed);
    sum.wanted += static_cast<double>(s.wanted);
    sum.found += static_cast<double>(s.found);
    sum.converged += static_cast<double>(s.converged);
    sum.wrong += static_cast<double>(s.impure + s.doubles);
    sum.errors.insert(sum.errors.end(), s.errors.begin(), s.errors.end());
  }
  return sum;
}

// Boxes drawn anew from the labels, ten times each. Recall is of the objects left with at least 3 boxes.
TEST(BrightonBeach, HoldsUnderTheRecordedNoise) {
  const auto sum = pooled({.misses = 0.10, .false_boxes = 0.05, .edge_px = 3.0});
  EXPECT_GE(sum.found, 0.97 * sum.wanted);
  EXPECT_LE(sum.wrong, 0.01 * sum.converged);
  EXPECT_LE(quantile(sum.errors, 0.95), 0.15);
}

TEST(BrightonBeach, HoldsUnderHarderNoise) {
  const auto sum = pooled({.misses = 0.20, .false_boxes = 0.20, .edge_px = 3.0});
  EXPECT_GE(sum.found, 0.95 * sum.wanted);
  EXPECT_LE(sum.wrong, 0.03 * sum.converged);
  EXPECT_LE(quantile(sum.errors, 0.5), 0.05);
  EXPECT_LE(quantile(sum.errors, 0.95), 0.20);
}

TEST(BrightonBeach, HoldsWhereEverySecondBoxIsFalse) {
  const auto sum = pooled({.misses = 0.30, .false_boxes = 1.00, .edge_px = 6.0});
  EXPECT_GE(sum.found, 0.95 * sum.wanted);
  EXPECT_LE(sum.wrong, 0.03 * sum.converged);
  EXPECT_LE(quantile(sum.errors, 0.95), 0.30);
}

}  // namespace
}  // namespace cairn::localisation
