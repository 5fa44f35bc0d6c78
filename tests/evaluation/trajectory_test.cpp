#include "evaluation/trajectory.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <cmath>
#include <numbers>

#include "base/error.hpp"

namespace cairn::evaluation {
namespace {

using geometry::Mat3;
using geometry::RigidTransform;
using geometry::Similarity;
using geometry::Vec3;

constexpr double kExact = 1e-9;  // m or deg: rounding of a hundred poses
constexpr double kSecond = 1e9;

// A helix, ten poses a second, that turns as it climbs.
std::vector<StampedPose> helix(std::size_t count) {
  std::vector<StampedPose> poses;
  for (std::size_t i = 0; i < count; ++i) {
    const double a = 0.1 * static_cast<double>(i);
    StampedPose p;
    p.time_ns = static_cast<std::int64_t>(i) * 100'000'000;
    p.id = static_cast<std::int64_t>(i);
    p.T_world_body = {geometry::axis_rotation(Vec3(1, 2, 3).normalized(), a),
                      Vec3(5.0 * std::cos(a), 3.0 * std::sin(a), 0.2 * a)};
    poses.push_back(p);
  }
  return poses;
}

std::vector<StampedPose> moved(std::vector<StampedPose> poses, const Similarity& s) {
  for (auto& p : poses) p.T_world_body = {s.rotation * p.T_world_body.rotation, s * p.T_world_body.translation};
  return poses;
}

const Similarity kMove{2.5, geometry::axis_rotation(Vec3(0.3, -1, 0.2).normalized(), 1.1), Vec3(4, -7, 11)};

TEST(Trajectory, EachAlignmentTakesAwayWhatItCan) {
  const auto truth = helix(100);
  const auto errors = [&](const std::vector<StampedPose>& estimate, const char* align) {
    TrajectoryOptions options;
    options.align = align;
    return score_trajectory(estimate, truth, pairs_by_time(estimate, truth, options), options);
  };
  const auto shifted = moved(truth, {1.0, Mat3::Identity(), Vec3(3, 4, 0)});
  EXPECT_NEAR(errors(shifted, "none").ate_m.rms, 5.0, kExact);
  EXPECT_NEAR(errors(shifted, "translation").ate_m.max, 0.0, kExact);
  const auto turned = moved(truth, {1.0, kMove.rotation, kMove.translation});
  EXPECT_GT(errors(turned, "translation").ate_m.rms, 1.0);
  EXPECT_NEAR(errors(turned, "se3").ate_m.max, 0.0, kExact);
  EXPECT_NEAR(errors(turned, "se3").ate_rotation_deg.max, 0.0, 1e-6);
  const auto scaled = moved(truth, kMove);
  EXPECT_GT(errors(scaled, "se3").ate_m.rms, 1.0);
  const auto sim3 = errors(scaled, "sim3");
  EXPECT_NEAR(sim3.ate_m.max, 0.0, kExact);
  EXPECT_NEAR(sim3.rpe_m.max, 0.0, kExact);
  EXPECT_NEAR(sim3.T_truth_estimate.scale, 0.4, kExact);
  EXPECT_NEAR((sim3.T_truth_estimate.rotation * kMove.rotation - Mat3::Identity()).norm(), 0.0, kExact);
}

// Mirrored positions: the least-squares rotation must not become a reflection (Umeyama's case det < 0).
TEST(Trajectory, AlignmentIsNeverAReflection) {
  std::vector<Vec3> from{{1, 0, 0}, {-1, 0, 0}, {0, 2, 0}, {0, -2, 0}, {0, 0, 3}, {0, 0, -3}}, to = from;
  for (auto& p : to) p.x() = -p.x();
  const auto s = align_points(from, to, Alignment::sim3);
  EXPECT_NEAR((s.rotation * s.rotation.transpose() - Mat3::Identity()).norm(), 0.0, kExact);
  EXPECT_NEAR(s.rotation.determinant(), 1.0, kExact);
  // Scale = (sum of the singular values with the last one's sign turned) / variance = (8 + 18 - 2) / 28.
  EXPECT_NEAR(s.scale, 24.0 / 28.0, kExact);
}

// A straight flight at 1 m/s east. The estimate runs 1 % fast and turns by 0.1 deg a pose.
TEST(Trajectory, HandComputedRelativeErrors) {
  std::vector<StampedPose> truth, estimate;
  for (int i = 0; i < 21; ++i) {
    StampedPose p;
    p.time_ns = static_cast<std::int64_t>(i * 0.5 * kSecond);
    p.T_world_body.translation = Vec3(0.5 * i, 0, 0);
    truth.push_back(p);
    p.T_world_body.translation *= 1.01;
    p.T_world_body.rotation = geometry::axis_rotation(Vec3::UnitX(), 0.1 * i * std::numbers::pi / 180.0);
    estimate.push_back(p);
  }
  TrajectoryOptions options;
  options.align = "none";
  const auto run = [&](double delta, const char* unit) {
    options.delta = delta;
    options.delta_unit = unit;
    return score_trajectory(estimate, truth, pairs_by_time(estimate, truth, options), options);
  };
  const auto frames = run(1, "frames");
  EXPECT_EQ(frames.relative_pairs, 20U);
  EXPECT_NEAR(frames.rpe_m.rms, 0.005, kExact);
  EXPECT_NEAR(frames.rpe_rotation_deg.median, 0.1, kExact);
  EXPECT_NEAR(frames.ate_m.max, 0.1, kExact);
  EXPECT_NEAR(frames.ate_rotation_deg.max, 2.0, kExact);
  const auto seconds = run(2, "seconds");
  EXPECT_EQ(seconds.relative_pairs, 17U);
  EXPECT_NEAR(seconds.rpe_m.rms, 0.02, kExact);
  const auto metres = run(5, "metres");
  EXPECT_EQ(metres.relative_pairs, 11U);
  EXPECT_NEAR(metres.rpe_m.mean, 0.05, kExact);
  EXPECT_NEAR(metres.rpe_rotation_deg.max, 1.0, kExact);
  EXPECT_EQ(run(50, "metres").relative_pairs, 0U);
  EXPECT_EQ(run(0.6, "seconds").relative_pairs, 0U);  // the next pose is 1 s away: more than a tenth too late
}

TEST(Trajectory, AssociationTakesTheNearestOnce) {
  const auto stamp = [](double seconds) {
    StampedPose p;
    p.time_ns = static_cast<std::int64_t>(std::llround(seconds * kSecond));
    return p;
  };
  const std::vector<StampedPose> estimate{stamp(2.0), stamp(1.0), stamp(1.012), stamp(5.0)};
  const std::vector<StampedPose> truth{stamp(2.005), stamp(1.01), stamp(4.97)};
  TrajectoryOptions options;
  // 1.012 is nearer to 1.01 than 1.0 is; 5.0 has none within 20 ms.
  EXPECT_EQ(pairs_by_time(estimate, truth, options), (Pairs{{2, 1}, {0, 0}}));
  options.max_difference_s = 0.05;
  EXPECT_EQ(pairs_by_time(estimate, truth, options), (Pairs{{2, 1}, {0, 0}, {3, 2}}));
  options.time_offset_s = 100.0;
  EXPECT_TRUE(pairs_by_time(estimate, truth, options).empty());
}

TEST(Trajectory, AssociationById) {
  auto estimate = helix(4), truth = helix(6);
  std::swap(truth[0], truth[3]);
  estimate[1].id = 77;
  estimate[2].id = -1;
  EXPECT_EQ(pairs_by_id(estimate, truth), (Pairs{{0, 3}, {3, 0}}));
}

TEST(Trajectory, TooLittleToAlign) {
  const auto two = helix(2);
  TrajectoryOptions options;
  EXPECT_THROW(static_cast<void>(score_trajectory(two, two, pairs_by_id(two, two), options)), base::Error);
  EXPECT_THROW(static_cast<void>(score_trajectory(two, two, {}, options)), base::Error);
  options.align = "translation";
  EXPECT_NEAR(score_trajectory(two, two, pairs_by_id(two, two), options).ate_m.max, 0.0, kExact);
  const std::vector<Vec3> still(5, Vec3(1, 2, 3));
  EXPECT_THROW(static_cast<void>(align_points(still, still, Alignment::sim3)), base::Error);
}

}  // namespace
}  // namespace cairn::evaluation
