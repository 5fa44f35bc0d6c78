#include "fragility/shake_suite.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/random.hpp"
#include "fragility/ground_motion.hpp"
#include "fragility/shake_plots.hpp"

namespace cairn::fragility {
namespace {

ProfileOfAzimuth block() {
  return [](double) { return rectangle_profile(0.25, 1.0); };
}

SuiteMotion motion(std::uint64_t key) {
  SuiteMotion m;
  m.name = "made up " + std::to_string(key);
  m.dt = 0.01;
  base::Random random(21, "suite", key);
  double a = 0.0;
  for (int i = 0; i < 600; ++i) m.horizontal.push_back(a = 0.9 * a + random.normal());
  const auto measure = measures(m.horizontal, m.dt);
  m.pga = measure.pga_m_s2;
  m.pgv = measure.pgv_m_s;
  return m;
}

TEST(ShakeSuite, EveryRunIsThereInItsOrderOnAnyNumberOfThreads) {
  const std::vector<SuiteMotion> motions = {motion(1), motion(2)};
  const std::vector<double> scales = {0.2, 1.0, 3.0};
  SuiteOptions options;
  options.azimuth_step_deg = 90.0;
  options.eta_draws = 2;
  base::RunContext ctx;
  const auto outcomes = run_suite(block(), motions, scales, options, ctx);
  ASSERT_EQ(outcomes.size(), 2U * 3U * 4U * 2U);
  EXPECT_EQ(outcomes[0].scale, 0.2);
  EXPECT_EQ(outcomes[1].eta_draw, 1U);
  EXPECT_EQ(outcomes[2].azimuth_deg, 90.0);
  EXPECT_EQ(outcomes.back().record, 1U);
  EXPECT_NEAR(outcomes.back().pga_g, 3.0 * motions[1].pga / kGravity, 1e-12);
  const base::ThreadLimit one(1);
  const auto again = run_suite(block(), motions, scales, options, ctx);
  for (std::size_t i = 0; i < outcomes.size(); ++i) EXPECT_EQ(outcomes[i].toppled, again[i].toppled);
}

// The block is symmetric: a direction and its opposite topple alike, to opposite sides.
TEST(ShakeSuite, OppositeDirectionsOfASymmetricBlock) {
  const std::vector<SuiteMotion> motions = {motion(3)};
  const std::vector<double> scales = {1.0, 2.0, 4.0};
  SuiteOptions options;
  options.azimuth_deg = 40.0;
  options.eta_draws = 1;
  base::RunContext ctx;
  const auto outcomes = run_suite(block(), motions, scales, options, ctx);
  ASSERT_EQ(outcomes.size(), 6U);
  EXPECT_TRUE(std::any_of(outcomes.begin(), outcomes.end(), [](const auto& o) { return o.toppled; }));
  for (std::size_t i = 0; i < 6; i += 2) {
    // Positive motion towards 40 is negative motion towards 220: the same physical run, seen from behind.
    EXPECT_EQ(outcomes[i].azimuth_deg, 40.0);
    EXPECT_EQ(outcomes[i + 1].azimuth_deg, 220.0);
    EXPECT_EQ(outcomes[i].toppled, outcomes[i + 1].toppled);
    if (outcomes[i].toppled) {
      EXPECT_NEAR(std::abs(outcomes[i].topple_toward_deg - outcomes[i + 1].topple_toward_deg), 180.0, 1e-9);
    }
  }
}

TEST(ShakeSuite, WrongSuitesAreRefused) {
  base::RunContext ctx;
  const std::vector<SuiteMotion> motions = {motion(1)};
  EXPECT_THROW((void)run_suite(block(), {}, std::vector<double>{1.0}, {}, ctx), base::Error);
  EXPECT_THROW((void)run_suite(block(), motions, std::vector<double>{-1.0}, {}, ctx), base::Error);
  auto still = motions;
  still[0].pga = 0.0;
  EXPECT_THROW((void)run_suite(block(), still, std::vector<double>{1.0}, {}, ctx), base::Error);
}

// Below a_qs nothing overturns; long strong pulses always do; the boundary falls with PGV/PGA.
TEST(ShakeSuite, OverturningMapOfABlock) {
  MapOptions map;
  map.pga_steps = 24;
  map.ratio_steps = 8;
  SuiteOptions options;
  options.azimuth_deg = 0.0;
  options.eta_draws = 2;
  base::RunContext ctx;
  const auto result = overturning_map(block(), map, options, ctx);
  ASSERT_EQ(result.share.size(), 24U * 8U);
  std::vector<double> least(8, 99.0);
  for (std::size_t r = 0; r < 8; ++r)
    for (std::size_t k = 0; k < 24; ++k) {
      if (result.share[r * 24 + k] > 0.0) least[r] = std::min(least[r], result.pga_g[k]);
      if (result.pga_g[k] < 0.25) {
        EXPECT_EQ(result.share[r * 24 + k], 0.0);
      }
    }
  EXPECT_EQ(result.share.back(), 1.0);
  EXPECT_LT(least[7], least[4]);
  const auto svg = overturning_map_svg(result, nullptr, "a < b", "block");
  EXPECT_THAT(svg, ::testing::HasSubstr("a &lt; b"));
  EXPECT_THAT(svg, ::testing::Not(::testing::HasSubstr("nan")));
}

}  // namespace
}  // namespace cairn::fragility
