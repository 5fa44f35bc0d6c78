#include "adjustment/bundle_datum.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "adjustment/robust.hpp"
#include "base/angle.hpp"
#include "geometry/alignment.hpp"

namespace cairn::adjustment {

using geometry::Mat3;
using geometry::RigidTransform;
using geometry::Similarity;
using geometry::Vec3;

BundlePrior prior_of(const survey::Frame& frame, const BundleOptions& options) {
  BundlePrior prior;
  prior.pose = frame.T_world_camera;
  if (!options.priors) return prior;
  const auto weight = [](double given, double own) {
    const double sigma = given > 0.0 ? given : own;
    return sigma > 0.0 ? 1.0 / sigma : 0.0;
  };
  prior.weight_xy = weight(options.prior_sigma_xy_m, frame.sigma_xy_m);
  prior.weight_z = weight(options.prior_sigma_z_m, frame.sigma_z_m);
  prior.weight_rot = weight(base::deg_to_rad(options.prior_sigma_rot_deg), base::deg_to_rad(frame.sigma_rot_deg));
  return prior;
}

bool in_line(std::span<const Vec3> points) {
  if (points.size() < 3) return true;
  Vec3 mean = Vec3::Zero();
  for (const auto& p : points) mean += p / static_cast<double>(points.size());
  Mat3 spread = Mat3::Zero();
  for (const auto& p : points) spread += (p - mean) * (p - mean).transpose();
  constexpr double kLine = 1e-6;  // of the variances
  const Vec3 variances = Eigen::JacobiSVD<Mat3>(spread).singularValues();
  return !(variances[1] > kLine * variances[0]);
}

bool fixes_datum(std::span<const BundlePrior> priors) {
  std::vector<Vec3> positions;
  bool turned = false;
  for (const auto& prior : priors) {
    if (prior.weight_xy > 0.0 && prior.weight_z > 0.0) positions.push_back(prior.pose.translation);
    turned = turned || prior.weight_rot > 0.0;
  }
  return !in_line(positions) || (positions.size() >= 2 && turned);
}

namespace {

Mat3 mean_turn(std::span<const RigidTransform> from, std::span<const RigidTransform> to) {
  Mat3 sum = Mat3::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) sum += to[i].rotation * from[i].rotation.transpose();
  return geometry::nearest_rotation(sum);
}

Similarity align_in_line(std::span<const RigidTransform> from, std::span<const RigidTransform> to) {
  Similarity T;
  T.rotation = mean_turn(from, to);
  Vec3 mean_from = Vec3::Zero(), mean_to = Vec3::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    mean_from += from[i].translation / static_cast<double>(from.size());
    mean_to += to[i].translation / static_cast<double>(from.size());
  }
  double along = 0.0, own = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Vec3 a = T.rotation * (from[i].translation - mean_from);
    along += a.dot(to[i].translation - mean_to);
    own += a.squaredNorm();
  }
  if (own > 0.0 && along > 0.0) T.scale = along / own;
  T.translation = mean_to - T.scale * (T.rotation * mean_from);
  return T;
}

}  // namespace

Similarity align_poses(std::span<const RigidTransform> from, std::span<const RigidTransform> to) {
  std::vector<Vec3> a, b;
  for (std::size_t i = 0; i < from.size(); ++i) {
    a.push_back(from[i].translation);
    b.push_back(to[i].translation);
  }
  std::vector<double> weights(a.size(), 1.0);
  auto T = in_line(b) ? std::nullopt : geometry::align_points(a, b);
  if (!T) return align_in_line(from, to);
  // One position that is far off would turn the whole block.
  constexpr int kRounds = 3;
  constexpr double kFar = 5.0;  // robust sigmas
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> distances;
    for (std::size_t i = 0; i < a.size(); ++i) distances.push_back((*T * a[i] - b[i]).norm());
    const double limit = kFar * 1.4826 * median(distances);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      weights[i] = distances[i] <= limit ? 1.0 : 0.0;
      kept += weights[i] > 0.0 ? 1U : 0U;
    }
    const auto again = kept < a.size() ? geometry::align_points(a, b, true, weights) : std::nullopt;
    if (!again) break;
    T = again;
  }
  return *T;
}

}  // namespace cairn::adjustment
