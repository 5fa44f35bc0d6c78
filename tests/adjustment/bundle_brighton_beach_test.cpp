// The real survey: COLMAP's tie points bring perturbed poses back to COLMAP's own.
#include <gtest/gtest.h>

#include "adjustment/bundle.hpp"
#include "adjustment/bundle_datum.hpp"
#include "geometry/alignment.hpp"
#include "support/block_survey.hpp"
#include "support/brighton_beach.hpp"

namespace cairn::adjustment {
namespace {

// 18 photographs from 40 m, poses off by 0.5 m and 1 deg a axis, points triangulated from those.
class PerturbedBrightonBeach : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(PerturbedBrightonBeach, ReturnsToColmapsPoses) {
  constexpr double kPosition_m = 0.02, kRotation_deg = 0.05;  // what a refined survey is to reach
  const auto survey = testing::brighton_beach_colmap(1.0);
  BundleProblem problem{survey.manifest.cameras, survey.frames, {}, survey.ties, {}};
  testing::perturb(problem, 0.5, 1.0, GetParam());
  base::RunContext ctx;
  const auto result = adjust_bundle(problem, {}, ctx);
  EXPECT_TRUE(result.converged);
  EXPECT_EQ(result.frames_adjusted, 18U);
  EXPECT_EQ(result.gauge, BundleGauge::aligned);
  const auto back = testing::aligned(result.frames, survey.frames);
  const auto d = testing::pose_difference(back, survey.frames);
  EXPECT_LT(d.position_m, kPosition_m);
  EXPECT_LT(d.rotation_deg, kRotation_deg);
  EXPECT_GT(result.rms_before_px, 10.0);
  EXPECT_LT(result.rms_after_px, 1.5);
}

INSTANTIATE_TEST_SUITE_P(Seeds, PerturbedBrightonBeach, ::testing::Values(1, 2, 3, 4, 5));

}  // namespace
}  // namespace cairn::adjustment
