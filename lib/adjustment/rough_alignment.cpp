#include "adjustment/rough_alignment.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "adjustment/robust.hpp"
#include "base/angle.hpp"
#include "base/parallel.hpp"

namespace cairn::adjustment {
namespace {

using geometry::Mat3;
using geometry::Vec2;
using geometry::Vec3;
using Mat6 = Eigen::Matrix<double, 6, 6>;
using Vec6 = Eigen::Matrix<double, 6, 1>;

constexpr std::size_t kGrain = 256;
constexpr double kLeastDepth = 1e-3;  // m

Vec3 direction_of(const TrackRay& ray, const RoughCamera& camera) {
  return camera.T_world_camera.rotation * Vec3(ray.at.x(), ray.at.y(), 1.0).normalized();
}

double largest_sine(std::span<const Vec3> directions) {
  double largest = 0.0;
  for (std::size_t i = 0; i < directions.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) largest = std::max(largest, directions[i].cross(directions[j]).norm());
  return largest;
}

bool before_all(std::span<const TrackRay> rays, std::span<const RoughCamera> cameras, const Vec3& p) {
  return std::all_of(rays.begin(), rays.end(), [&](const TrackRay& ray) {
    const auto& T = cameras[ray.camera].T_world_camera;
    return T.rotation.col(2).dot(p - T.translation) > kLeastDepth;
  });
}

// Mean of where the rays meet the level plane; empty where one does not.
std::optional<Vec3> on_plane(std::span<const TrackRay> rays, std::span<const RoughCamera> cameras, double up) {
  Vec3 sum = Vec3::Zero();
  for (const auto& ray : rays) {
    const auto& camera = cameras[ray.camera];
    const Vec3 d = direction_of(ray, camera);
    const Vec3& c = camera.T_world_camera.translation;
    constexpr double kLeastDrop = 0.1;  // about 6 degrees below the horizon
    if (!(d.z() < -kLeastDrop) || !(c.z() > up)) return std::nullopt;
    sum += c + (up - c.z()) / d.z() * d;
  }
  return sum / static_cast<double>(rays.size());
}

Mat3 cross_matrix(const Vec3& v) {
  Mat3 m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

Vec3 rotation_vector(const Mat3& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

struct Seen {
  Vec3 p_world;
  Vec2 at;
};

// One Gauss-Newton step; rotation in camera axes, position in the world.
void resect_once(RoughCamera& camera, const RoughCamera& prior, std::span<const Seen> seen, double scale) {
  auto& T = camera.T_world_camera;
  Mat6 normal = Mat6::Zero();
  Vec6 right = Vec6::Zero();
  for (const auto& s : seen) {
    const Vec3 p = T.rotation.transpose() * (s.p_world - T.translation);
    if (!(p.z() > kLeastDepth)) continue;
    const Vec2 residual = p.head<2>() / p.z() - s.at;
    Eigen::Matrix<double, 2, 3> of_point;
    of_point << 1.0 / p.z(), 0.0, -p.x() / (p.z() * p.z()), 0.0, 1.0 / p.z(), -p.y() / (p.z() * p.z());
    Eigen::Matrix<double, 2, 6> jacobian;
    jacobian << of_point * cross_matrix(p), -of_point * T.rotation.transpose();
    const double weight = std::min(1.0, scale / std::max(residual.norm(), 1e-12)) / (scale * scale);
    normal += weight * jacobian.transpose() * jacobian;
    right -= weight * jacobian.transpose() * residual;
  }
  const auto& T0 = prior.T_world_camera;
  const double rot = base::deg_to_rad(prior.sigma_rot_deg);
  const Vec3 turned = rotation_vector(T0.rotation.transpose() * T.rotation), moved = T.translation - T0.translation;
  const Vec3 sigma(prior.sigma_xy_m, prior.sigma_xy_m, prior.sigma_z_m);
  for (int i = 0; i < 3; ++i) {
    normal(i, i) += 1.0 / (rot * rot);
    right[i] -= turned[i] / (rot * rot);
    normal(i + 3, i + 3) += 1.0 / (sigma[i] * sigma[i]);
    right[i + 3] -= moved[i] / (sigma[i] * sigma[i]);
  }
  const Vec6 step = normal.ldlt().solve(right);
  if (!step.allFinite()) return;
  const Vec3 w = step.head<3>();
  const double angle = w.norm();
  if (angle > 0.0) T.rotation = T.rotation * geometry::axis_rotation(w / angle, angle);
  T.translation += step.tail<3>();
}

}  // namespace

std::optional<Vec3> intersect_rays(std::span<const TrackRay> rays, std::span<const RoughCamera> cameras,
                                   double least_sine) {
  std::vector<Vec3> directions;
  for (const auto& ray : rays) directions.push_back(direction_of(ray, cameras[ray.camera]));
  if (!(largest_sine(directions) >= least_sine)) return std::nullopt;
  Vec3 p = Vec3::Zero();
  std::vector<double> weights(rays.size(), 1.0);
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    Mat3 normal = Mat3::Zero();
    Vec3 right = Vec3::Zero();
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Mat3 across = weights[i] * (Mat3::Identity() - directions[i] * directions[i].transpose());
      normal += across;
      right += across * cameras[rays[i].camera].T_world_camera.translation;
    }
    p = normal.ldlt().solve(right);
    if (!p.allFinite()) return std::nullopt;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const double depth = directions[i].dot(p - cameras[rays[i].camera].T_world_camera.translation);
      weights[i] = 1.0 / std::max(depth * depth, kLeastDepth);
    }
  }
  if (!before_all(rays, cameras, p)) return std::nullopt;
  return p;
}

double ray_residual(const TrackRay& ray, const RoughCamera& camera, const Vec3& p_world) {
  const auto& T = camera.T_world_camera;
  const Vec3 p = T.rotation.transpose() * (p_world - T.translation);
  if (!(p.z() > kLeastDepth)) return std::numeric_limits<double>::infinity();
  return (p.head<2>() / p.z() - ray.at).norm();
}

double align_roughly(std::vector<RoughCamera>& cameras, std::vector<RayTrack>& tracks, std::optional<double> ground_up,
                     const RoughAlignmentOptions& options) {
  const std::vector<RoughCamera> priors = cameras;
  std::vector<std::vector<std::pair<std::size_t, Vec2>>> of_camera(cameras.size());
  for (std::size_t t = 0; t < tracks.size(); ++t)
    for (const auto& ray : tracks[t].rays) of_camera[ray.camera].emplace_back(t, ray.at);

  const auto intersect = [&](bool level) {
    base::parallel_for(tracks.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) {
        auto& track = tracks[t];
        const auto p =
            level ? on_plane(track.rays, cameras, *ground_up) : intersect_rays(track.rays, cameras, options.least_sine);
        track.seen = p.has_value();
        if (p) track.p_world = *p;
      }
    });
  };
  const auto median_residual = [&] {
    std::vector<double> residuals;
    for (const auto& track : tracks)
      if (track.seen)
        for (const auto& ray : track.rays) residuals.push_back(ray_residual(ray, cameras[ray.camera], track.p_world));
    return residuals.empty() ? std::numeric_limits<double>::infinity() : median(std::move(residuals));
  };

  for (int round = 0; round < options.rounds; ++round) {
    intersect(ground_up && round < options.plane_rounds);
    const double middle = median_residual();
    if (!std::isfinite(middle)) break;
    const double scale = std::max(options.scale, 1.5 * middle);
    base::parallel_for(cameras.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t c = begin; c < end; ++c) {
        std::vector<Seen> seen;
        for (const auto& [t, at] : of_camera[c])
          if (tracks[t].seen) seen.push_back({tracks[t].p_world, at});
        constexpr std::size_t kLeastPoints = 6;
        if (seen.size() < kLeastPoints) continue;
        constexpr int kSteps = 2;
        for (int step = 0; step < kSteps; ++step) resect_once(cameras[c], priors[c], seen, scale);
      }
    });
  }
  intersect(false);
  return median_residual();
}

}  // namespace cairn::adjustment
