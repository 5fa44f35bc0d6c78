#include "adjustment/bundle.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "adjustment/bundle_datum.hpp"
#include "base/error.hpp"
#include "geometry/alignment.hpp"
#include "support/bal.hpp"
#include "support/block_survey.hpp"

namespace cairn::adjustment {
namespace {

using geometry::Vec3;
using testing::BlockSurvey;
using testing::pose_difference;

// Frames of a result brought onto others by the similarity of their positions: what a free block can be judged by.
std::vector<survey::Frame> aligned(const std::vector<survey::Frame>& frames, const std::vector<survey::Frame>& to) {
  std::vector<geometry::RigidTransform> a, b;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    a.push_back(frames[i].T_world_camera);
    b.push_back(to[i].T_world_camera);
  }
  const auto T = align_poses(a, b);
  auto result = frames;
  for (auto& frame : result) frame.T_world_camera = geometry::transform_pose(T, frame.T_world_camera);
  return result;
}

BundleResult adjust(const BundleProblem& problem, const BundleOptions& options = {}) {
  base::RunContext ctx;
  return adjust_bundle(problem, options, ctx);
}

TEST(Bundle, RecoversNoiseFreeBlockExactly) {
  constexpr double kTol_m = 1e-5, kTol_deg = 1e-5;  // the solver's tolerance on a cost that tends to zero
  for (const auto model : {survey::CameraModel::pinhole, survey::CameraModel::radial, survey::CameraModel::brown,
                           survey::CameraModel::fisheye}) {
    const BlockSurvey block({.model = model});
    const auto result = adjust(block.perturbed(0.5, 1.0, 7));
    EXPECT_TRUE(result.converged);
    EXPECT_EQ(result.gauge, BundleGauge::aligned);
    EXPECT_EQ(result.frames_adjusted, block.truth.frames.size());
    const auto d = pose_difference(aligned(result.frames, block.truth.frames), block.truth.frames);
    EXPECT_LT(d.position_m, kTol_m);
    EXPECT_LT(d.rotation_deg, kTol_deg);
    EXPECT_GT(result.rms_before_px, 5.0);
    EXPECT_LT(result.rms_after_px, 1e-3);
  }
}

}  // namespace
}  // namespace cairn::adjustment
