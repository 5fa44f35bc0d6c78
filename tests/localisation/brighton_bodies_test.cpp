// The joint fit on the recorded survey: nadir photos, so that the heights rest on the priors and the plan does not.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "localisation/body_fit.hpp"
#include "localisation/locate.hpp"
#include "support/brighton_boxes.hpp"

namespace cairn::localisation {
namespace {

using geometry::Vec3;
using testing::BoxedSurvey;

constexpr double kFound = 1.5;  // m: a target of the same class this near counts as the object

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return std::numeric_limits<double>::infinity();
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::floor(q * static_cast<double>(values.size() - 1) + 0.5))];
}

struct Score {
  std::size_t wanted = 0, refined = 0, false_ones = 0;
  std::vector<double> fitted_m, triangulated_m;  // horizontal errors of the same objects
};

void add_score(const BoxedSurvey& boxed, std::uint64_t seed, Score* s) {
  base::RunContext ctx;
  ctx.seed = seed;
  auto result = locate(boxed.survey, {}, ctx);
  (void)refine_bodies(result.targets, boxed.survey, {}, ctx);
  std::map<std::string, std::set<std::int64_t>> photos;
  for (std::size_t i = 0; i < boxed.object_of.size(); ++i)
    if (!boxed.object_of[i].empty()) photos[boxed.object_of[i]].insert(boxed.survey.detections[i].frame.value);
  for (const auto& row : testing::brighton_objects()) {
    if (photos[row.at("object_id")].size() < 3) continue;
    ++s->wanted;
    const Vec3 at(std::stod(row.at("east_m")), std::stod(row.at("north_m")), std::stod(row.at("up_m")));
    const survey::Target* nearest = nullptr;
    double best = kFound;
    for (const auto& target : result.targets) {
      if (!target.refined || target.object_class != row.at("class")) continue;
      const double distance = (target.refined->centre - at).head<2>().norm();
      if (distance >= best) continue;
      best = distance;
      nearest = &target;
    }
    if (nearest == nullptr) continue;
    s->fitted_m.push_back(best);
    s->triangulated_m.push_back((nearest->centre - at).head<2>().norm());
  }
  for (const auto& target : result.targets) {
    if (!target.refined) continue;
    ++s->refined;
    std::map<std::string, std::size_t> votes;
    for (const auto id : target.detections) {
      const auto& object = boxed.object_of[static_cast<std::size_t>(id.value) - 1];
      if (!object.empty()) ++votes[object];
    }
    const bool pure =
        std::any_of(votes.begin(), votes.end(), [&](const auto& v) { return 2 * v.second > target.detections.size(); });
    if (!pure) ++s->false_ones;
  }
}

TEST(BrightonBodies, FittedBodiesStandWhereTheObjectsAre) {
  Score s;
  add_score(testing::brighton_detections(), 0, &s);
  RecordProperty("median_mm", static_cast<int>(1000.0 * quantile(s.fitted_m, 0.5)));
  RecordProperty("p95_mm", static_cast<int>(1000.0 * quantile(s.fitted_m, 0.95)));
  RecordProperty("triangulated_median_mm", static_cast<int>(1000.0 * quantile(s.triangulated_m, 0.5)));
  RecordProperty("triangulated_p95_mm", static_cast<int>(1000.0 * quantile(s.triangulated_m, 0.95)));
  EXPECT_EQ(s.wanted, 37U);
  EXPECT_GE(s.fitted_m.size(), 36U);  // 97.3 %
  EXPECT_LE(quantile(s.fitted_m, 0.5), 0.04);
  EXPECT_LE(quantile(s.fitted_m, 0.95), 0.15);
}

// Boxes drawn anew from the labels with the recorded noise, pooled over ten seeds.
TEST(BrightonBodies, HoldsUnderTheRecordedNoise) {
  Score s;
  for (std::uint64_t seed = 1; seed <= 10; ++seed)
    add_score(testing::brighton_noisy({.misses = 0.10, .false_boxes = 0.05, .edge_px = 3.0}, seed), seed, &s);
  EXPECT_GE(static_cast<double>(s.fitted_m.size()), 0.95 * static_cast<double>(s.wanted));
  EXPECT_LE(static_cast<double>(s.false_ones), 0.03 * static_cast<double>(s.refined));
  EXPECT_LE(quantile(s.fitted_m, 0.5), 0.04);
  EXPECT_LE(quantile(s.fitted_m, 0.95), 0.15);
}

}  // namespace
}  // namespace cairn::localisation
