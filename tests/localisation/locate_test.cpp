#include "localisation/locate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "support/nadir_survey.hpp"

namespace cairn::localisation {
namespace {

using geometry::Vec3;
using survey::FrameId;
using survey::TargetState;

LocateOptions level_ground() {
  LocateOptions options;
  options.ground_up_m = 0.0;
  return options;
}

LocateResult run(const survey::Survey& survey, const LocateOptions& options = level_ground(), std::uint64_t seed = 0) {
  base::RunContext ctx;
  ctx.seed = seed;
  return locate(survey, options, ctx);
}

// Every detection is in one target or among the rejects; nothing written is NaN.
void expect_sound(const survey::Survey& survey, const LocateResult& result) {
  std::multiset<std::int64_t> seen;
  for (const auto& target : result.targets) {
    for (const auto id : target.detections) seen.insert(id.value);
    EXPECT_TRUE(target.centre.allFinite());
    EXPECT_TRUE(target.covariance.allFinite());
    ASSERT_TRUE(target.bcylinder);
    EXPECT_TRUE(std::isfinite(target.bcylinder->radius) && std::isfinite(target.bcylinder->height()));
    EXPECT_GE(target.bcylinder->radius, 0.0);
    EXPECT_LE(target.bcylinder->bottom, target.bcylinder->top);
    for (const double h : target.entropy_nats) EXPECT_TRUE(std::isfinite(h));
    for (const double d : target.divergence) EXPECT_TRUE(std::isfinite(d));
    EXPECT_TRUE(std::isfinite(target.mean_score));
  }
  for (const auto& reject : result.rejects)
    if (reject.record.starts_with("detection ")) seen.insert(std::stoll(reject.record.substr(10)));
  EXPECT_EQ(seen.size(), survey.detections.size());
  for (const auto& detection : survey.detections) EXPECT_EQ(seen.count(detection.id.value), 1U) << detection.id.value;
  EXPECT_EQ(result.counts.used + result.counts.rejected, survey.detections.size());
  EXPECT_EQ(result.targets.size(), result.evidence.size());
  EXPECT_EQ(result.targets.size(), result.points.size());
}

TEST(Locate, FindsObjectsFromFewPhotos) {
  testing::NadirSurvey s(4);
  const std::vector<Vec3> truth{{8, 0, 0.5}, {10, 1, 0.3}, {14, -4, 0.8}, {12, 6, 0.4}};
  for (const auto& at : truth) ASSERT_GE(s.object(at), 3);
  const auto result = run(s.survey);
  expect_sound(s.survey, result);
  ASSERT_EQ(result.targets.size(), truth.size());
  for (const auto& at : truth) {
    double nearest = 1e9;
    for (const auto& target : result.targets) {
      EXPECT_EQ(target.state, TargetState::converged);
      nearest = std::min(nearest, (target.centre - at).norm());
    }
    EXPECT_LT(nearest, 1e-6);  // m; boxes without noise meet exactly
  }
}

TEST(Locate, SaysHowSureTheCentreIs) {
  testing::NadirSurvey s(5, 4.0);
  s.object({8, 0, 0.5});
  LocateOptions options = level_ground();
  options.sigma_px = 2.0;
  options.sigma_size = 0.0;
  options.outline_sigma = 0.0;
  const auto result = run(s.survey, options);
  ASSERT_EQ(result.targets.size(), 1U);
  const auto& covariance = result.targets[0].covariance;
  // Five views of 2 px at 0.0395 m a pixel: 0.035 m level; the points' spread is ten times that.
  EXPECT_NEAR(std::sqrt(covariance(1, 1)), 2.0 * 0.0395 / std::sqrt(5.0), 0.004);
  EXPECT_GT(std::sqrt(result.evidence[0].points_covariance(1, 1)), 0.1);
}

TEST(Locate, DropsAWrongBoxFromATarget) {
  testing::NadirSurvey s(5, 4.0);
  s.object({8, 0, 0.5});
  auto& box = s.survey.detections[2].box;  // half a metre aside, where the filter's points still are
  box.ymin += 16;
  box.ymax += 16;
  LocateOptions options = level_ground();
  options.sigma_px = 1.0;
  const auto result = run(s.survey, options);
  expect_sound(s.survey, result);
  EXPECT_THAT(result.rejects, ::testing::Contains(::testing::Field(&base::Reject::reason, "box_outlier")));
  EXPECT_LT((result.targets[0].centre - Vec3(8, 0, 0.5)).norm(), 1e-6);
  EXPECT_EQ(result.targets[0].detections.size(), 4U);
}

TEST(Locate, OneDirectionStaysUnconvergedAndSaysSo) {
  testing::NadirSurvey s(6, 0.0);
  s.object({1, 1, 0.5});
  const auto result = run(s.survey);
  expect_sound(s.survey, result);
  ASSERT_EQ(result.targets.size(), 1U);
  EXPECT_NE(result.targets[0].state, TargetState::converged);
  EXPECT_THAT(result.targets[0].reasons, ::testing::Contains("one_direction"));
  EXPECT_EQ(result.targets[0].detections.size(), 6U);
}

TEST(Locate, TooLittleParallaxStaysUnconverged) {
  testing::NadirSurvey s(6, 0.2);  // 1 m of base at 40 m: 1.4 deg
  s.object({0.5, 1, 0.5});
  const auto result = run(s.survey);
  ASSERT_EQ(result.targets.size(), 1U);
  EXPECT_NE(result.targets[0].state, TargetState::converged);
  EXPECT_THAT(result.targets[0].reasons, ::testing::Contains("one_direction"));
}

TEST(Locate, SeenOnceAndTwice) {
  testing::NadirSurvey s(2);
  s.object({4, 0, 0.5});
  s.box(FrameId(1), {480, 300, 510, 330}, "boulder");
  const auto result = run(s.survey);
  expect_sound(s.survey, result);
  ASSERT_EQ(result.targets.size(), 2U);
  EXPECT_THAT(result.targets[0].reasons, ::testing::Contains("too_few_boxes"));
  EXPECT_EQ(result.targets[0].state, TargetState::converging);
  EXPECT_EQ(result.targets[1].state, TargetState::deregistered);
  EXPECT_THAT(result.targets[1].reasons, ::testing::Contains("seen_once"));
}

TEST(Locate, RarelySeenIsNotBelieved) {
  testing::NadirSurvey s(16, 1.0);
  s.object({8, 0, 0.5});
  // 3 of 16 frames show it, all others should.
  std::vector<survey::Detection> kept;
  for (const auto& d : s.survey.detections)
    if (d.frame.value % 6 == 1) kept.push_back(d);
  s.survey.detections = kept;
  const auto result = run(s.survey);
  expect_sound(s.survey, result);
  ASSERT_EQ(result.targets.size(), 1U);
  EXPECT_EQ(result.targets[0].state, TargetState::deregistered);
  EXPECT_THAT(result.targets[0].reasons, ::testing::Contains("rarely_seen"));
}

TEST(Locate, ObjectBoxedTwiceIsOneTarget) {
  testing::NadirSurvey s(5, 4.0);
  s.object({8, 0, 0.5}, 1.0);
  s.object({8, 0, 0.5}, 1.5);  // boxes too different to be duplicates of one another (IoU 0.44)
  const auto result = run(s.survey);
  expect_sound(s.survey, result);
  std::size_t converged = 0;
  for (const auto& target : result.targets) converged += target.state == TargetState::converged ? 1U : 0U;
  EXPECT_EQ(converged, 1U);
}

TEST(Locate, BadBoxesNeverBecomeNumbers) {
  testing::NadirSurvey s(5, 4.0);
  s.object({8, 0, 0.5});
  s.box(FrameId(1), {500, 500, 500, 500}, "boulder");
  s.box(FrameId(1), {std::nan(""), 1, 2, 3}, "boulder");
  s.box(FrameId(77), {100, 100, 120, 120}, "boulder");
  auto& again = s.box(FrameId(1), s.survey.detections[0].box, "boulder");
  again.score = 0.1;
  for (const auto* mode : {"robust", "paper"}) {
    LocateOptions options = level_ground();
    options.mode = mode;
    const auto result = run(s.survey, options);
    expect_sound(s.survey, result);
    EXPECT_GE(result.counts.rejected, 3U) << mode;
  }
}

TEST(Locate, NothingToDo) {
  testing::NadirSurvey s(2);
  EXPECT_TRUE(run(s.survey).targets.empty());
  EXPECT_TRUE(run(survey::Survey{}).targets.empty());
}

TEST(Locate, AllPointsBehindTheNextCamera) {
  // The second camera looks up from above the scene: the points lie behind it, its box lies elsewhere.
  testing::NadirSurvey s(2);
  s.survey.frames[1].T_world_camera.rotation = geometry::Mat3::Identity();
  s.box(FrameId(1), {480, 480, 520, 520}, "boulder");
  s.box(FrameId(2), {480, 480, 520, 520}, "boulder");
  for (const auto* mode : {"robust", "paper"}) {
    LocateOptions options = level_ground();
    options.mode = mode;
    expect_sound(s.survey, run(s.survey, options));
  }
}

TEST(Locate, TheSameWhateverTheThreads) {
  testing::NadirSurvey s(8, 4.0);
  for (int i = 0; i < 20; ++i) s.object({2.0 + 1.3 * i, -6.0 + 0.7 * i, 0.5});
  const auto once = [&](int threads) {
    const base::ThreadLimit limit(threads);
    return run(s.survey);
  };
  const auto one = once(1), four = once(4);
  ASSERT_EQ(one.targets.size(), four.targets.size());
  for (std::size_t i = 0; i < one.targets.size(); ++i) {
    EXPECT_EQ(one.targets[i].centre, four.targets[i].centre);
    EXPECT_EQ(one.points[i], four.points[i]);
    EXPECT_EQ(one.targets[i].entropy_nats, four.targets[i].entropy_nats);
  }
}

TEST(Locate, SeedsChangeThePointsNotTheCentres) {
  testing::NadirSurvey s(5, 4.0);
  s.object({8, 0, 0.5});
  const auto a = run(s.survey, level_ground(), 1), b = run(s.survey, level_ground(), 2);
  EXPECT_NE(a.points[0], b.points[0]);
  EXPECT_LT((a.targets[0].centre - b.targets[0].centre).norm(), 1e-9);
}

TEST(Locate, DepthBoundOfTheConsumerIsUsed) {
  testing::NadirSurvey s(5, 4.0);
  s.object({8, 0, 0.5});
  base::RunContext ctx;
  std::size_t calls = 0;
  const auto result = locate(s.survey, {}, ctx, [&](const View& view, const Vec3& direction) {
    ++calls;
    EXPECT_LT(direction.z(), 0.0);
    return std::optional<DepthRange>({view.T_world_camera.translation.z() - 2.0, view.T_world_camera.translation.z()});
  });
  EXPECT_GT(calls, 0U);
  EXPECT_EQ(result.counts.depth_source, "bound");
  EXPECT_TRUE(ctx.warnings().empty());
  EXPECT_EQ(result.counts.converged, 1U);
}

TEST(Locate, WarnsWhereNothingGivesTheDepth) {
  testing::NadirSurvey s(5, 4.0);
  s.object({8, 0, 0.5});
  base::RunContext ctx;
  const auto result = locate(s.survey, {}, ctx);
  EXPECT_EQ(result.counts.depth_source, "default");
  ASSERT_EQ(ctx.warnings().size(), 1U);
  EXPECT_THAT(ctx.warnings()[0], ::testing::HasSubstr("--max-depth-m"));
}

TEST(Locate, RefusesOptionsOutOfRange) {
  LocateOptions options;
  options.min_points_fraction = 1.5;
  EXPECT_THROW(run({}, options), base::Error);
  options = {};
  options.min_depth_m = 20.0;
  options.max_depth_m = 10.0;
  EXPECT_THROW(run({}, options), base::Error);
  options = {};
  options.gaussian_weight = options.uniform_weight = 0.0;
  EXPECT_THROW(run({}, options), base::Error);
}

TEST(Locate, PaperReportsTheSpreadAsSuch) {
  testing::NadirSurvey s(6, 4.0);
  s.object({10, 0, 0.5});
  LocateOptions options;
  options.mode = "paper";
  options.max_depth_m = 42.0;
  const auto result = run(s.survey, options);
  expect_sound(s.survey, result);
  ASSERT_FALSE(result.targets.empty());
  EXPECT_THAT(result.targets[0].reasons, ::testing::Contains("covariance_is_spread"));
  EXPECT_EQ(result.targets[0].centre, result.evidence[0].points_mean);
}

}  // namespace
}  // namespace cairn::localisation
