#include "localisation/triangulation.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "base/random.hpp"
#include "support/nadir_survey.hpp"

namespace cairn::localisation {
namespace {

using geometry::Mat3;
using geometry::Vec2;
using geometry::Vec3;

std::vector<FrameView> frames(int count, double spacing = 8.0) {
  static std::vector<testing::NadirSurvey> kept;  // the cameras must outlive the views
  kept.reserve(64);
  const auto& survey = kept.emplace_back(count, spacing).survey;
  std::vector<FrameView> views;
  for (const auto& frame : survey.frames) {
    FrameView view;
    view.id = frame.id;
    view.camera = &survey.manifest.cameras[0];
    view.view = ideal_view(*view.camera, frame.T_world_camera);
    views.push_back(view);
  }
  return views;
}

std::vector<Sighting> sight(const std::vector<FrameView>& views, const Vec3& at, double sigma = 1.0) {
  std::vector<Sighting> result;
  for (const auto& view : views) result.push_back({&view, *view.view.project(at), Vec2::Constant(sigma), false});
  return result;
}

TEST(Triangulate, IsExactWithoutNoise) {
  const auto views = frames(5);
  const Vec3 truth(14.0, 3.0, 1.5);
  const auto fix = triangulate(sight(views, truth), {});
  ASSERT_TRUE(fix);
  EXPECT_LT((fix->centre - truth).norm(), 1e-8);  // m; Gauss-Newton stops at 1e-9
  EXPECT_EQ(fix->inliers, 5U);
  EXPECT_NEAR(fix->rms_px, 0.0, 1e-6);
  EXPECT_NEAR(fix->parallax_rad, std::atan2(14.0, 38.5) + std::atan2(18.0, 38.5), 0.01);
}

// Two views by hand: depth sigma = z^2 / (f b) sqrt(2) sigma_px over the base b.
TEST(Triangulate, CovarianceOfAStereoPair) {
  const auto views = frames(2, 10.0);
  const auto fix = triangulate(sight(views, {5.0, 0.0, 0.0}), {});
  ASSERT_TRUE(fix);
  const double depth = 40.0 * 40.0 / (1000.0 * 10.0) * std::sqrt(2.0);
  EXPECT_NEAR(std::sqrt(fix->covariance(2, 2)), depth, 0.01 * depth);
}

// Honest: the squared normalised error has mean 3 over many draws, position and rotation errors included.
TEST(Triangulate, CovarianceIsHonest) {
  const Vec3 truth(14.0, 3.0, 1.5);
  base::Random random(13, "test", 0);
  double sum = 0.0;
  constexpr int kRuns = 2000;
  for (int run = 0; run < kRuns; ++run) {
    auto views = frames(5);
    std::vector<Sighting> sightings;
    for (auto& view : views) {
      view.sigma_xy_m = view.sigma_z_m = 0.05;
      view.sigma_rot_rad = 0.001;
      View wrong = view.view;
      wrong.T_world_camera.translation += 0.05 * Vec3(random.normal(), random.normal(), random.normal());
      const Vec3 turn = 0.001 * Vec3(random.normal(), random.normal(), random.normal());
      wrong.T_world_camera.rotation =
          geometry::axis_rotation(turn.normalized(), turn.norm()) * wrong.T_world_camera.rotation;
      sightings.push_back({&view, *wrong.project(truth) + Vec2(random.normal(), random.normal()), Vec2::Ones(), false});
    }
    const auto fix = triangulate(sightings, {.gate = 20.0});
    ASSERT_TRUE(fix);
    const Vec3 error = fix->centre - truth;
    sum += error.dot(fix->covariance.inverse() * error);
  }
  // chi-square with 3 degrees of freedom: mean 3, variance 6; five standard errors, and 3 % for Huber's weights.
  EXPECT_NEAR(sum / kRuns, 3.0, 5.0 * std::sqrt(6.0 / kRuns) + 0.09);
}

TEST(Triangulate, RemovesOutliers) {
  const auto views = frames(5);
  const Vec3 truth(14.0, 3.0, 1.5);
  auto sightings = sight(views, truth);
  sightings[1].centre_px += Vec2(0, 60);
  const auto fix = triangulate(sightings, {});
  ASSERT_TRUE(fix);
  EXPECT_LT((fix->centre - truth).norm(), 1e-6);
  EXPECT_EQ(fix->inlier, (std::vector<bool>{true, false, true, true, true}));
}

TEST(Triangulate, ACutBoxHelpsOnlyAcrossTheBorder) {
  const auto views = frames(3);
  const Vec3 truth(8.0, 0.0, 1.0);
  auto sightings = sight(views, truth);
  sightings[2].cut = true;
  sightings[2].centre_px.x() += 20.0;
  sightings[2].sigma_px = Vec2(25.0, 1.0);
  const auto fix = triangulate(sightings, {});
  ASSERT_TRUE(fix);
  EXPECT_EQ(fix->inliers, 3U);
  EXPECT_LT((fix->centre - truth).norm(), 0.05);
  sightings[1].cut = true;
  EXPECT_FALSE(triangulate(sightings, {})) << "one whole box does not make a target";
}

TEST(Triangulate, RefusesParallelRaysAndPointsBehind) {
  const auto same_place = frames(4, 0.0);
  EXPECT_FALSE(triangulate(sight(same_place, {3.0, 1.0, 0.0}), {}));
  const auto views = frames(2, 10.0);
  // Rays that diverge downwards meet above the cameras.
  std::vector<Sighting> diverging{{&views[0], Vec2(400, 500), Vec2::Ones(), false},
                                  {&views[1], Vec2(600, 500), Vec2::Ones(), false}};
  EXPECT_FALSE(triangulate(diverging, {}));
  EXPECT_FALSE(triangulate(std::vector<Sighting>{diverging[0]}, {}));
  EXPECT_FALSE(triangulate({}, {}));
}

TEST(SquaredDistance, CountsInSigmas) {
  const auto views = frames(1);
  const Sighting s{&views[0], Vec2(503, 500), Vec2(3.0, 1.0), false};
  EXPECT_NEAR(*squared_distance(s, {0, 0, 0}, Mat3::Zero()), 1.0, 1e-12);
  // A point known to 0.12 m (3 px) only: sigmas add in square.
  EXPECT_NEAR(*squared_distance(s, {0, 0, 0}, 0.12 * 0.12 * Mat3::Identity()), 0.5, 1e-9);
  EXPECT_FALSE(squared_distance(s, {0, 0, 50}, Mat3::Zero()));
}

}  // namespace
}  // namespace cairn::localisation
