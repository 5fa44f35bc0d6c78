#include "evaluation/trajectory.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <tuple>

#include "base/error.hpp"

namespace cairn::evaluation {
namespace {

using geometry::Mat3;
using geometry::RigidTransform;
using geometry::Similarity;
using geometry::Vec3;

constexpr double kNanoseconds = 1e9;
constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr double kLateness = 0.1;  // of delta

Vec3 mean(const std::vector<Vec3>& points) {
  Vec3 sum = Vec3::Zero();
  for (const auto& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

std::vector<std::size_t> by_time(const std::vector<StampedPose>& poses) {
  std::vector<std::size_t> order(poses.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return poses[a].time_ns < poses[b].time_ns; });
  return order;
}

// The partner of each pose for the relative error; its own index where it has none.
std::vector<std::size_t> partners(const std::vector<RigidTransform>& truth, const std::vector<double>& seconds,
                                  const TrajectoryOptions& options) {
  const std::size_t n = truth.size();
  std::vector<std::size_t> partner(n);
  if (options.delta_unit == "frames") {
    const auto step = static_cast<std::size_t>(std::max(1.0, std::round(options.delta)));
    for (std::size_t i = 0; i < n; ++i) partner[i] = i + step < n ? i + step : i;
    return partner;
  }
  std::vector<double> along(seconds);
  if (options.delta_unit == "metres") {
    along.assign(n, 0.0);
    for (std::size_t i = 1; i < n; ++i)
      along[i] = along[i - 1] + (truth[i].translation - truth[i - 1].translation).norm();
  }
  for (std::size_t i = 0; i < n; ++i) {
    // What rounding may take from a distance that equals delta.
    const double wanted = along[i] + options.delta * (1.0 - 1e-9);
    const auto at = std::lower_bound(along.begin() + static_cast<std::ptrdiff_t>(i), along.end(), wanted);
    const auto j = static_cast<std::size_t>(at - along.begin());
    partner[i] = j < n && along[j] - along[i] <= (1.0 + kLateness) * options.delta ? j : i;
  }
  return partner;
}

}  // namespace

Alignment alignment_of(const TrajectoryOptions& options) {
  if (options.align == "none") return Alignment::none;
  if (options.align == "translation") return Alignment::translation;
  return options.align == "se3" ? Alignment::se3 : Alignment::sim3;
}

Pairs pairs_by_time(const std::vector<StampedPose>& estimate, const std::vector<StampedPose>& truth,
                    const TrajectoryOptions& options) {
  const auto limit = static_cast<std::int64_t>(std::llround(options.max_difference_s * kNanoseconds));
  const auto offset = static_cast<std::int64_t>(std::llround(options.time_offset_s * kNanoseconds));
  const auto order = by_time(estimate), truth_order = by_time(truth);
  std::vector<std::tuple<std::int64_t, std::size_t, std::size_t>> candidates;
  std::size_t first = 0;
  for (const auto i : order) {
    const std::int64_t time = estimate[i].time_ns + offset;
    while (first < truth_order.size() && truth[truth_order[first]].time_ns < time - limit) ++first;
    for (std::size_t k = first; k < truth_order.size() && truth[truth_order[k]].time_ns <= time + limit; ++k)
      candidates.emplace_back(std::abs(truth[truth_order[k]].time_ns - time), i, truth_order[k]);
  }
  std::sort(candidates.begin(), candidates.end());
  std::vector<char> used(estimate.size(), 0), truth_used(truth.size(), 0);
  Pairs pairs;
  for (const auto& [difference, i, j] : candidates) {
    if (used[i] != 0 || truth_used[j] != 0) continue;
    used[i] = truth_used[j] = 1;
    pairs.emplace_back(i, j);
  }
  std::sort(pairs.begin(), pairs.end(), [&](const auto& a, const auto& b) {
    return std::pair(estimate[a.first].time_ns, a.first) < std::pair(estimate[b.first].time_ns, b.first);
  });
  return pairs;
}

Pairs pairs_by_id(const std::vector<StampedPose>& estimate, const std::vector<StampedPose>& truth) {
  std::map<std::int64_t, std::size_t> known;
  for (std::size_t j = 0; j < truth.size(); ++j)
    if (truth[j].id >= 0) known.emplace(truth[j].id, j);
  Pairs pairs;
  for (const auto i : by_time(estimate))
    if (const auto found = known.find(estimate[i].id); found != known.end()) pairs.emplace_back(i, found->second);
  return pairs;
}

Similarity align_points(const std::vector<Vec3>& from, const std::vector<Vec3>& to, Alignment alignment) {
  Similarity s;
  if (alignment == Alignment::none) return s;
  const std::size_t needed = alignment == Alignment::translation ? 1 : 3;
  if (from.size() < needed || from.size() != to.size())
    throw base::Error(base::ErrorCode::failed_precondition, "too few matched poses to align the trajectory")
        .found(std::to_string(from.size()))
        .allowed("at least " + std::to_string(needed))
        .hint("Raise --max-difference-s, set --time-offset-s, or use --align none");
  const Vec3 from_mean = mean(from), to_mean = mean(to);
  if (alignment == Alignment::translation) {
    s.translation = to_mean - from_mean;
    return s;
  }
  const auto n = static_cast<double>(from.size());
  Mat3 covariance = Mat3::Zero();
  double variance = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    covariance += (to[i] - to_mean) * (from[i] - from_mean).transpose() / n;
    variance += (from[i] - from_mean).squaredNorm() / n;
  }
  const Eigen::JacobiSVD<Mat3> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vec3 sign = Vec3::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) sign.z() = -1.0;
  s.rotation = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  if (alignment == Alignment::sim3) {
    s.scale = variance > 0.0 ? svd.singularValues().dot(sign) / variance : 0.0;
    if (!(s.scale > 0.0))
      throw base::Error(base::ErrorCode::failed_precondition, "the trajectory's positions coincide: it has no scale")
          .hint("Use --align se3 or translation");
  }
  s.translation = to_mean - s.scale * (s.rotation * from_mean);
  return s;
}

TrajectoryErrors score_trajectory(const std::vector<StampedPose>& estimate, const std::vector<StampedPose>& truth,
                                  const Pairs& pairs, const TrajectoryOptions& options) {
  if (pairs.empty())
    throw base::Error(base::ErrorCode::failed_precondition, "no pose of the trajectory has a partner in the truth")
        .found("estimate " + std::to_string(estimate.size()) + ", truth " + std::to_string(truth.size()) + " poses")
        .hint("Raise --max-difference-s, or set --time-offset-s where the clocks differ");
  std::vector<Vec3> from, to;
  for (const auto& [i, j] : pairs) {
    from.push_back(estimate[i].T_world_body.translation);
    to.push_back(truth[j].T_world_body.translation);
  }
  TrajectoryErrors errors;
  errors.pairs = pairs.size();
  errors.T_truth_estimate = align_points(from, to, alignment_of(options));
  const Similarity& s = errors.T_truth_estimate;
  std::vector<RigidTransform> aligned, target;
  std::vector<double> seconds, rotations;
  const std::int64_t start = estimate[pairs.front().first].time_ns;
  for (const auto& [i, j] : pairs) {
    const auto& pose = estimate[i].T_world_body;
    aligned.push_back({s.rotation * pose.rotation, s * pose.translation});
    target.push_back(truth[j].T_world_body);
    seconds.push_back(static_cast<double>(estimate[i].time_ns - start) / kNanoseconds);
    errors.position_errors_m.push_back((aligned.back().translation - target.back().translation).norm());
    rotations.push_back(kDegrees *
                        geometry::rotation_angle(target.back().rotation.transpose() * aligned.back().rotation));
  }
  errors.ate_m = spread(errors.position_errors_m);
  errors.ate_rotation_deg = spread(rotations);

  std::vector<double> steps, turns;
  const auto partner = partners(target, seconds, options);
  for (std::size_t i = 0; i < partner.size(); ++i) {
    const std::size_t j = partner[i];
    if (j == i) continue;
    const RigidTransform moved = target[i].inverse() * target[j], estimated = aligned[i].inverse() * aligned[j];
    const RigidTransform error = moved.inverse() * estimated;
    steps.push_back(error.translation.norm());
    turns.push_back(kDegrees * geometry::rotation_angle(error.rotation));
  }
  errors.relative_pairs = steps.size();
  errors.rpe_m = spread(steps);
  errors.rpe_rotation_deg = spread(turns);
  return errors;
}

}  // namespace cairn::evaluation
