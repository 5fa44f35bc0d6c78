#include "segmentation/rock_patch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/random.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Vec2;
using geometry::Vec3;

constexpr double kSpacing = 0.012;  // m, of the made clouds
constexpr double kTurn = 2.0 * std::numbers::pi;

// A ball of 0.4 m that is cut flat and stands on a post of 0.3 m radius and 0.5 m height, on a lawn. The rim has
// 0.24 m radius at 0.5 m.
struct BallOnPost {
  std::vector<Vec3> points;
  std::vector<Label> truth;

  BallOnPost() {
    base::Random random(5, "ball_on_post", 0);
    const double density = 1.0 / (kSpacing * kSpacing);
    const auto add = [&](const Vec3& p, Label label) {
      points.push_back(p + 0.004 * Vec3(random.normal(), random.normal(), random.normal()));
      truth.push_back(label);
    };
    const auto count = [&](double area) { return static_cast<int>(area * density); };
    for (int i = 0; i < count(2.56); ++i) {
      const Vec3 p(random.uniform(-0.8, 0.8), random.uniform(-0.8, 0.8), 0.0);
      if (p.norm() > 0.3) add(p, Label::terrain);
    }
    for (int i = 0; i < count(kTurn * 0.3 * 0.5); ++i) {
      const double a = random.uniform(0, kTurn);
      add({0.3 * std::cos(a), 0.3 * std::sin(a), random.uniform(0, 0.5)}, Label::pedestal);
    }
    for (int i = 0; i < count(0.5 * kTurn * (0.3 * 0.3 - 0.24 * 0.24)); ++i) {
      const double a = random.uniform(0, kTurn), r = std::sqrt(random.uniform(0.24 * 0.24, 0.3 * 0.3));
      add({r * std::cos(a), r * std::sin(a), 0.5}, Label::pedestal);
    }
    for (int i = 0; i < count(kTurn * 0.4 * 0.72); ++i) {  // Archimedes: even in height
      const double z = random.uniform(-0.32, 0.4), a = random.uniform(0, kTurn), r = std::sqrt(0.16 - z * z);
      add({r * std::cos(a), r * std::sin(a), 0.82 + z}, Label::rock);
    }
  }
  [[nodiscard]] PatchInput input() const {
    PatchInput in;
    in.points = points;
    in.centre = Vec2(0.02, -0.03);
    in.radius = 0.45;
    return in;
  }
};

double iou(std::span<const Label> found, std::span<const Label> truth, Label label) {
  double both = 0, any = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (found[i] == Label::basal_contact) continue;  // lies on either
    both += found[i] == label && truth[i] == label;
    any += found[i] == label || truth[i] == label;
  }
  return both / any;
}

TEST(RockPatch, TellsABallFromItsPostAndTheLawn) {
  const BallOnPost scene;
  const auto result = segment_patch(scene.input(), {});
  ASSERT_TRUE(result.found()) << result.reason << " " << result.message;
  EXPECT_GT(iou(result.labels, scene.truth, Label::rock), 0.97);
  EXPECT_GT(iou(result.labels, scene.truth, Label::pedestal), 0.85);
  EXPECT_NEAR(result.height, 1.22, 0.02);
  EXPECT_NEAR(result.ground.up_at_centre, 0.0, 0.01);
  ASSERT_GE(result.contact.size(), 20U);
  double off = 0.0;
  for (const auto& v : result.contact) {
    off += std::hypot(v.position.head<2>().norm() - 0.24, v.position.z() - 0.5);
    EXPECT_TRUE(v.closed);
    EXPECT_GT(v.sigma_m, 0.0);
  }
  EXPECT_LT(off / static_cast<double>(result.contact.size()), kSpacing);
  for (const float p : result.probability) {
    EXPECT_GE(p, 0.0F);
    EXPECT_LE(p, 1.0F);
  }
}

TEST(RockPatch, TheContactFollowsFromTheLabels) {
  const BallOnPost scene;
  const auto contact = contact_from_labels(scene.points, scene.truth);
  ASSERT_GE(contact.size(), 20U);
  double off = 0.0;
  for (const auto& v : contact) off += std::hypot(v.position.head<2>().norm() - 0.24, v.position.z() - 0.5);
  EXPECT_LT(off / static_cast<double>(contact.size()), kSpacing);
  const std::vector<Label> all_rock(scene.points.size(), Label::rock);
  EXPECT_TRUE(contact_from_labels(scene.points, all_rock).empty());
  EXPECT_TRUE(contact_from_labels({}, {}).empty());
}

TEST(RockPatch, DoesNotDependOnWhereOrInWhatOrder) {
  const BallOnPost scene;
  const auto result = segment_patch(scene.input(), {});
  std::vector<Vec3> reversed(scene.points.rbegin(), scene.points.rend());
  auto in = scene.input();
  in.points = reversed;
  const auto again = segment_patch(in, {});
  std::size_t other = 0;
  for (std::size_t i = 0; i < reversed.size(); ++i) other += again.labels[i] != result.labels[reversed.size() - 1 - i];
  EXPECT_LT(other, reversed.size() / 100);
  EXPECT_NEAR(static_cast<double>(again.contact.size()), static_cast<double>(result.contact.size()), 8.0);
}

TEST(RockPatch, PicksAreObeyed) {
  const BallOnPost scene;
  auto in = scene.input();
  // A person takes the post for part of the rock: the crease at its foot is the contact.
  for (int i = 0; i < 24; ++i)
    for (const double z : {0.1, 0.2, 0.3, 0.4, 0.49}) {
      const double a = kTurn * i / 24;
      in.picks.push_back({{0.3 * std::cos(a), 0.3 * std::sin(a), z}, true});
    }
  const auto result = segment_patch(in, {});
  ASSERT_TRUE(result.found()) << result.reason;
  double up = 0.0;
  for (const auto& v : result.contact) up += v.position.z() / static_cast<double>(result.contact.size());
  EXPECT_LT(up, 0.12);
}

TEST(RockPatch, AGivenContactIsTakenAsItStands) {
  const BallOnPost scene;
  auto in = scene.input();
  for (int i = 0; i < 60; ++i) {
    const double a = kTurn * i / 60;
    in.contact.push_back({0, i, {0.25 * std::cos(a), 0.25 * std::sin(a), 0.51}, true, true, 0.002});
  }
  const auto result = segment_patch(in, {});
  ASSERT_TRUE(result.found());
  ASSERT_EQ(result.contact.size(), 60U);
  EXPECT_EQ(result.contact[7].position, in.contact[7].position);
  EXPECT_GT(iou(result.labels, scene.truth, Label::rock), 0.97);
}

std::string reason_of(const std::vector<Vec3>& points, double radius = 0.45) {
  PatchInput in;
  in.points = points;
  in.radius = radius;
  const auto result = segment_patch(in, {});
  EXPECT_EQ(result.labels.size(), points.size());
  EXPECT_TRUE(result.found() || !result.message.empty());
  for (const auto& v : result.contact) EXPECT_TRUE(v.position.allFinite());
  return result.reason;
}

TEST(RockPatch, BadCloudsHaveReasons) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(reason_of({}), "no_points");
  EXPECT_EQ(reason_of({{nan, 0, 0}, {50, 0, 0}}), "no_points");
  EXPECT_EQ(reason_of({{0, 0, 0}}), "two_points");
  EXPECT_EQ(reason_of({{0, 0, 0}, {0.1, 0, 0.4}}), "two_points");
  EXPECT_EQ(reason_of(std::vector<Vec3>(500, Vec3(0.1, 0.1, 1.0))), "two_points");  // one point, 500 times

  base::Random random(1, "bad", 0);
  std::vector<Vec3> lawn, wall, noise;
  for (int i = 0; i < 20000; ++i) {
    lawn.emplace_back(random.uniform(-1, 1), random.uniform(-1, 1), 0.005 * random.normal());
    wall.emplace_back(random.uniform(-1, 1), 0.0, random.uniform(0, 1));
    const double r = 0.4 * std::cbrt(random.uniform()), c = random.uniform(-1, 1), a = random.uniform(0, kTurn);
    noise.push_back({r * std::sqrt(1 - c * c) * std::cos(a), r * std::sqrt(1 - c * c) * std::sin(a), 0.6 + r * c});
  }
  EXPECT_EQ(reason_of(lawn), "not_above_ground");
  EXPECT_EQ(reason_of(wall), "planar");
  noise.insert(noise.end(), lawn.begin(), lawn.end());
  EXPECT_EQ(reason_of(noise), "not_a_surface");
  std::vector<Vec3> few(lawn.begin(), lawn.begin() + 4000);
  for (int i = 0; i < 20; ++i) few.emplace_back(0.01 * i, 0.0, 0.5);
  EXPECT_EQ(reason_of(few), "too_few_points");
}

TEST(RockPatch, DuplicatePointsChangeNothingMuch) {
  const BallOnPost scene;
  std::vector<Vec3> doubled = scene.points;
  doubled.insert(doubled.end(), scene.points.begin(), scene.points.end());
  auto in = scene.input();
  in.points = doubled;
  const auto result = segment_patch(in, {});
  ASSERT_TRUE(result.found()) << result.reason;
  EXPECT_THAT(result.notes, ::testing::Contains("duplicate_points"));
  EXPECT_GT(iou(std::span(result.labels).first(scene.truth.size()), scene.truth, Label::rock), 0.97);
}

TEST(RockPatch, ARockWithoutVisibleBaseIsSaidSo) {
  // Only what lies above 0.75 m was seen, and the lawn.
  const BallOnPost scene;
  std::vector<Vec3> seen;
  for (const Vec3& p : scene.points)
    if (p.z() > 0.75 || p.z() < 0.03) seen.push_back(p);
  auto in = scene.input();
  in.points = seen;
  const auto result = segment_patch(in, {});
  if (result.found()) {
    EXPECT_THAT(result.notes, ::testing::Contains("hidden_base"));
    for (const auto& v : result.contact) EXPECT_FALSE(v.observed);
  } else {
    EXPECT_EQ(result.reason, "no_contact");
  }
}

}  // namespace
}  // namespace cairn::segmentation
