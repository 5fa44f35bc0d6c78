#include "segmentation/rock_cut.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/random.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Vec2;
using geometry::Vec3;

struct Boulder {
  Vec2 centre;
  double a, b, height;  // half-ellipsoid on the ground, m
};

constexpr double kSlope = 0.1;
constexpr double kNoise = 0.01;

double ground_up(const Vec2& p) {
  return 50.0 + kSlope * p.x();
}

// A 20 x 20 m lawn seen from above at the density given, with boulders.
geometry::PointCloud lawn(const std::vector<Boulder>& boulders, double per_m2, double noise = kNoise) {
  base::Random random(17, "lawn", 0);
  geometry::PointCloud cloud;
  const auto count = static_cast<int>(400 * per_m2);
  for (int i = 0; i < count; ++i) {
    const Vec2 p(random.uniform(-10, 10), random.uniform(-10, 10));
    double up = 0.0;
    for (const auto& b : boulders) {
      const Vec2 d = p - b.centre;
      const double q = d.x() * d.x() / (b.a * b.a) + d.y() * d.y() / (b.b * b.b);
      if (q < 1) up = b.height * std::sqrt(1 - q);
    }
    cloud.positions.emplace_back(p.x(), p.y(), ground_up(p) + up + noise * random.normal());
  }
  return cloud;
}

RockTarget target(std::int64_t id, const Vec2& centre, double radius) {
  return {survey::TargetId(id), "boulder", centre, radius};
}

TEST(RockCut, CutsEachBoulderOnASlope) {
  const std::vector<Boulder> boulders = {{{-4, 3}, .6, .5, .6}, {{5, -2}, 1.0, .8, .9}};
  auto cloud = lawn(boulders, 400);
  base::RunContext ctx;
  const auto cuts = cut_rocks(cloud, {target(7, {5.1, -2.1}, 1.0), target(3, {-4, 3.05}, .6)}, {}, ctx);
  ASSERT_EQ(cuts.rocks.size(), 2U);
  EXPECT_TRUE(cuts.rejects.empty());
  EXPECT_EQ(cuts.rocks[0].target.value, 3);
  for (std::size_t k = 0; k < 2; ++k) {
    const auto& rock = cuts.rocks[k];
    const auto& b = boulders[k];
    std::size_t inside = 0, expected = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Vec2 d = cloud.positions[i].head<2>() - b.centre;
      const bool truth = d.x() * d.x() / (b.a * b.a) + d.y() * d.y() / (b.b * b.b) < 1;
      const bool found = cuts.target_ids[i] == static_cast<std::uint32_t>(rock.target.value);
      EXPECT_EQ(found, cuts.labels[i] == Label::rock && found);
      expected += truth || found;
      inside += truth && found;
    }
    EXPECT_GE(static_cast<double>(inside) / static_cast<double>(expected), 0.97);  // IoU
    EXPECT_NEAR(rock.shape.height, b.height, 3 * kNoise + 0.01);
    EXPECT_NEAR(rock.ground.up_at_centre, ground_up(rock.ground.centre), 0.003);
    EXPECT_NEAR(rock.ground.slope.x(), kSlope, 0.003);
    EXPECT_NEAR(rock.ground.noise, kNoise, 0.002);
    EXPECT_NEAR(rock.shape.spacing, 0.5 / std::sqrt(400), 0.01);
    EXPECT_GT(rock.shape.sides_seen_share, 0.8);
    ASSERT_GT(rock.shape.contact.size(), 30U);
    for (const auto& c : rock.shape.contact) {
      EXPECT_NEAR(c.position.z(), ground_up(c.position.head<2>()), 0.01);
      const Vec2 d = c.position.head<2>() - b.centre;
      // 10 deg sectors hold a handful of points each: the rim is found to about three plan spacings (0.05 m).
      const double rim = std::sqrt(d.x() * d.x() / (b.a * b.a) + d.y() * d.y() / (b.b * b.b));
      EXPECT_NEAR(rim * std::min(b.a, b.b), std::min(b.a, b.b), 0.15);
    }
  }
  add_label_columns(cloud, cuts);
  EXPECT_TRUE(cloud.consistent());
  ASSERT_NE(cloud.scalar("target_id"), nullptr);
  EXPECT_EQ(cloud.scalar("target_id")->values[cuts.rocks[0].points[0]], 3.0);
  EXPECT_EQ(cloud.scalar("label")->values[cuts.rocks[0].points[0]], 2.0);
}

TEST(RockCut, SteepFlanksSeenFromTheSideAreObserved) {
  // A cylinder with points on its wall, against the same cylinder seen from above only.
  for (const bool wall : {true, false}) {
    auto cloud = lawn({}, 400, 0.002);
    std::erase_if(cloud.positions, [](const Vec3& p) { return p.head<2>().norm() < 0.5; });
    base::Random random(2, "wall", 0);
    for (int i = 0; i < 8000; ++i) {
      const double a = random.uniform(0, 6.28318);
      const double r = wall && i % 2 == 0 ? 0.5 : 0.5 * std::sqrt(random.uniform());
      const Vec2 p(r * std::cos(a), r * std::sin(a));
      cloud.positions.emplace_back(p.x(), p.y(), ground_up(p) + (wall && i % 2 == 0 ? random.uniform(0, 0.8) : 0.8));
    }
    base::RunContext ctx;
    const auto cuts = cut_rocks(cloud, {target(1, {0, 0}, .5)}, {}, ctx);
    ASSERT_EQ(cuts.rocks.size(), 1U);
    const auto& rock = cuts.rocks[0];
    const auto observed =
        std::count_if(rock.shape.contact.begin(), rock.shape.contact.end(), [](const auto& c) { return c.observed; });
    if (wall) {
      EXPECT_GE(observed, 32);
      EXPECT_GT(rock.shape.sides_seen_share, 0.95);
    } else {
      EXPECT_EQ(observed, 0);
      EXPECT_LT(rock.shape.sides_seen_share, 0.2);
    }
  }
}

TEST(RockCut, EveryRejectHasItsReason) {
  auto cloud = lawn({{{-4, 3}, .6, .5, .6}, {{2, 2}, .15, .15, .3}}, 400);
  // A hole in the cloud around (6, 6), just the size of the cylinder.
  std::erase_if(cloud.positions, [](const Vec3& p) { return (p.head<2>() - Vec2(6, 6)).norm() < 1.1; });
  // An island: points in the cylinder, none around it.
  for (int i = 0; i < 100; ++i) cloud.positions.emplace_back(100 + 0.03 * (i % 10), 100 + 0.03 * (i / 10), 50);
  base::RunContext ctx;
  const auto cuts =
      cut_rocks(cloud,
                {target(1, {50, 50}, .5), target(2, {6, 6}, .5), target(3, {0, -5}, .5), target(4, {2, 2}, .3),
                 target(5, {100.1, 100.1}, .5), target(6, {-4, 3}, .6), target(8, {-4.1, 3}, .6)},
                {}, ctx);
  ASSERT_EQ(cuts.rocks.size(), 1U);
  EXPECT_EQ(cuts.rocks[0].target.value, 6);
  std::vector<std::pair<std::string, std::string>> found;
  for (const auto& r : cuts.rejects) {
    found.emplace_back(r.record, r.reason);
    EXPECT_FALSE(r.message.empty());
  }
  using P = std::pair<std::string, std::string>;
  EXPECT_THAT(found, ::testing::ElementsAre(P("target 1", "cloud_missing"), P("target 2", "no_points"),
                                            P("target 3", "not_above_ground"), P("target 4", "too_few_points"),
                                            P("target 5", "ground_not_seen"), P("target 8", "duplicate_of_target")));
}

TEST(RockCut, SameForAnyNumberOfThreads) {
  const auto cloud = lawn({{{-4, 3}, .6, .5, .6}, {{5, -2}, 1.0, .8, .9}}, 200);
  std::vector<RockTarget> targets;
  for (int i = 0; i < 20; ++i) targets.push_back(target(i, {-9.0 + i, i % 2 == 0 ? 3.0 : -2.0}, 0.8));
  base::RunContext ctx;
  const auto one = [&] {
    const base::ThreadLimit limit(1);
    return cut_rocks(cloud, targets, {}, ctx);
  }();
  const base::ThreadLimit four(4);
  const auto many = cut_rocks(cloud, targets, {}, ctx);
  EXPECT_EQ(one.target_ids, many.target_ids);
  EXPECT_EQ(one.labels, many.labels);
  EXPECT_EQ(one.rejects, many.rejects);
}

TEST(RockCut, RefusesBrokenTargets) {
  base::RunContext ctx;
  const auto cloud = lawn({}, 10);
  EXPECT_THROW((void)cut_rocks(cloud, {target(1, {std::nan(""), 0}, 1)}, {}, ctx), base::Error);
  EXPECT_THROW((void)cut_rocks(cloud, {target(1, {0, 0}, 1), target(1, {3, 3}, 1)}, {}, ctx), base::Error);
  const auto empty = cut_rocks({}, {target(1, {0, 0}, 1)}, {}, ctx);
  ASSERT_EQ(empty.rejects.size(), 1U);
  EXPECT_EQ(empty.rejects[0].reason, "cloud_missing");
}

}  // namespace
}  // namespace cairn::segmentation
