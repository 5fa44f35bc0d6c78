// The simulated scans that methods are tuned and judged on: their truth must hold together.
#include "support/rock_scan.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace cairn::testing {
namespace {

RockScanOptions coarse() {
  RockScanOptions options;
  options.spacing_m = 0.03;
  options.edge_m = 0.06;
  return options;
}

std::size_t count(const std::vector<std::uint8_t>& labels, std::uint8_t label) {
  return static_cast<std::size_t>(std::count(labels.begin(), labels.end(), label));
}

TEST(RockScan, TruthHoldsTogether) {
  constexpr double kAngle = 1e-9;  // deg
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const auto scan = make_rock_scan(seed, coarse());
    EXPECT_NE(scan.family, kHeldOutFamily);
    EXPECT_TRUE(geometry::topology(scan.body).closed());
    EXPECT_GT(scan.mass.volume, 0.0);
    ASSERT_GT(scan.alpha_rim_deg(), 0.0) << seed;
    ASSERT_GT(scan.alpha_bearing_deg(), 0.0) << seed;
    // What bears lies inside the rim: the hull of less contact cannot hold the rock better.
    EXPECT_LE(scan.alpha_bearing_deg(), scan.alpha_rim_deg() + 0.5) << seed;
    EXPECT_GE(scan.hidden_share, 0.0);
    EXPECT_LE(scan.hidden_share, 1.0);
    EXPECT_TRUE(scan.cloud.scalars.empty());  // nothing in the cloud tells the truth
    ASSERT_EQ(scan.label.size(), scan.cloud.size());
    EXPECT_GT(count(scan.label, 2), 500U);
    EXPECT_GT(count(scan.label, 3), 50U);
    EXPECT_GT(count(scan.label, 1), 500U);
    // A basal point keeps the body it lies on in `surface`.
    for (std::size_t i = 0; i < scan.label.size(); ++i)
      if (scan.label[i] == 4) {
        EXPECT_TRUE(scan.surface[i] == 2 || scan.surface[i] == 3);
      }
    const auto pointwise = fragility::tipping(scan.mass, scan.rim.front());
    EXPECT_NEAR(pointwise.alpha_point, scan.on_rim.alpha_point, kAngle);
  }
}

TEST(RockScan, TheSameSeedGivesTheSameBytesAndAnotherSamplingOtherPoints) {
  auto options = coarse();
  const auto one = make_rock_scan(5, options), again = make_rock_scan(5, options);
  ASSERT_EQ(one.cloud.size(), again.cloud.size());
  EXPECT_TRUE(std::equal(one.cloud.positions.begin(), one.cloud.positions.end(), again.cloud.positions.begin()));
  options.sampling = 1;
  const auto other = make_rock_scan(5, options);
  EXPECT_EQ(one.body.vertices.size(), other.body.vertices.size());
  EXPECT_EQ(one.alpha_rim_deg(), other.alpha_rim_deg());
  EXPECT_FALSE(one.cloud.size() == other.cloud.size() &&
               std::equal(one.cloud.positions.begin(), one.cloud.positions.end(), other.cloud.positions.begin()));
}

TEST(RockScan, WhatHidesTheContactHidesSomeOfIt) {
  auto options = coarse();
  options.hiding = Hiding::none;
  const auto open = make_rock_scan(7, options);
  options.hiding = Hiding::brush;
  const auto brush = make_rock_scan(7, options);
  EXPECT_LT(open.hidden_share, 0.1);
  EXPECT_GT(brush.hidden_share, open.hidden_share);
  EXPECT_GT(count(brush.label, 0), 0U);  // the shrubs
  EXPECT_EQ(open.alpha_rim_deg(), brush.alpha_rim_deg());
}

TEST(RockScan, ScenesHoldTheRocksAskedFor) {
  RockSceneOptions options;
  options.on_pedestals = 2;
  options.on_ground = 2;
  options.touching_pairs = 1;
  options.shrubs = 2;
  options.spacing_m = 0.08;
  const auto scene = make_rock_scene(3, options);
  ASSERT_EQ(scene.rocks.size(), 6U);
  for (const auto& rock : scene.rocks) {
    std::size_t points = 0;
    for (std::size_t i = 0; i < scene.label.size(); ++i)
      if (scene.label[i] == 2 && scene.target_id[i] == static_cast<std::uint32_t>(rock.id.value)) ++points;
    EXPECT_GT(points, 30U) << rock.id.value;
  }
  EXPECT_GT(count(scene.label, 0), 20U);
}

}  // namespace
}  // namespace cairn::testing
