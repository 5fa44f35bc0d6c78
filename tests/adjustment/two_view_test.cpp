// Matches of a made scene with wrong ones among them: which are kept?
#include "adjustment/two_view.hpp"

#include <gmock/gmock.h>

#include "base/random.hpp"
#include "geometry/rigid_transform.hpp"

namespace cairn::adjustment {
namespace {

using geometry::Vec2;
using geometry::Vec3;

struct Scene {
  std::vector<RayMatch> matches;
  std::vector<bool> right;
};

// `relief` m of height over ground 40 m below, base line of 15 m, `wrong` matches of 200 at random places.
Scene scene(double relief, std::size_t wrong) {
  base::Random random(3, "two views", 0);
  const geometry::RigidTransform T_b_a{geometry::axis_rotation(Vec3::UnitZ(), 0.1), Vec3(-15.0, 2.0, 0.5)};
  Scene result;
  constexpr std::size_t kMatches = 200;
  for (std::size_t i = 0; i < kMatches; ++i) {
    const Vec3 p(random.uniform(-15.0, 40.0), random.uniform(-18.0, 18.0), 40.0 - relief * random.uniform(0.0, 1.0));
    const Vec3 q = T_b_a * p;
    RayMatch match{p.head<2>() / p.z(), q.head<2>() / q.z()};
    const bool is_wrong = i < wrong;
    if (is_wrong) match.b = Vec2(random.uniform(-0.9, 0.9), random.uniform(-0.5, 0.5));
    result.matches.push_back(match);
    result.right.push_back(!is_wrong);
  }
  return result;
}

TEST(TwoView, OverFlatGroundTheModelIsPlanarAndWrongMatchesAreDropped) {
  const auto s = scene(1.0, 60);
  const auto result = verify_two_views(s.matches);
  EXPECT_EQ(result.model, TwoViewModel::planar);
  std::size_t kept_wrong = 0, lost = 0;
  for (std::size_t i = 0; i < s.matches.size(); ++i) {
    kept_wrong += !s.right[i] && result.inlier[i] != 0 ? 1U : 0U;
    lost += s.right[i] && result.inlier[i] == 0 ? 1U : 0U;
  }
  EXPECT_EQ(lost, 0U);
  EXPECT_LE(kept_wrong, 1U);
}

TEST(TwoView, WithReliefTheModelIsEssential) {
  const auto s = scene(20.0, 60);
  const auto result = verify_two_views(s.matches);
  EXPECT_EQ(result.model, TwoViewModel::essential);
  std::size_t lost = 0;
  for (std::size_t i = 0; i < s.matches.size(); ++i) lost += s.right[i] && result.inlier[i] == 0 ? 1U : 0U;
  EXPECT_EQ(lost, 0U);
  EXPECT_GE(result.inliers, 140U);
  EXPECT_LE(result.inliers, 143U);
}

TEST(TwoView, RandomMatchesAreNotAScene) {
  const auto s = scene(1.0, 200);
  const auto result = verify_two_views(s.matches);
  EXPECT_EQ(result.model, TwoViewModel::none);
  EXPECT_EQ(result.inliers, 0U);
}

TEST(TwoView, TheSameOnEveryRun) {
  const auto s = scene(5.0, 80);
  EXPECT_EQ(verify_two_views(s.matches).inlier, verify_two_views(s.matches).inlier);
}

TEST(TwoView, FewMatchesAreRefused) {
  const auto s = scene(5.0, 0);
  EXPECT_EQ(verify_two_views(std::span(s.matches).first(10)).model, TwoViewModel::none);
}

}  // namespace
}  // namespace cairn::adjustment
