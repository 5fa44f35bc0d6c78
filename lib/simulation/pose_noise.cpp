#include "simulation/pose_noise.hpp"

#include <cmath>

#include "base/angle.hpp"
#include "base/random.hpp"

namespace cairn::simulation {
namespace {

using geometry::Vec3;

Vec3 normals(base::Random& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return {x, y, z};
}

geometry::Mat3 small_rotation(const Vec3& vector) {
  const double angle = vector.norm();
  return angle > 0.0 ? geometry::axis_rotation(vector / angle, angle) : geometry::Mat3(geometry::Mat3::Identity());
}

}  // namespace

std::vector<NoisyPose> noisy_poses(const PoseNoise& noise, std::uint64_t seed, std::span<const double> times_s,
                                   std::span<const geometry::RigidTransform> poses) {
  // Each part has numbers of its own: changing one sigma leaves the other errors as they were.
  base::Random white(seed, "simulation pose white", 0), walking(seed, "simulation pose walk", 0),
      constant(seed, "simulation pose constant", 0), turning(seed, "simulation pose attitude", 0);
  const Vec3 bias = normals(constant).cwiseProduct(Vec3(noise.constant_xy_m, noise.constant_xy_m, noise.constant_z_m));
  const Vec3 mounted = base::deg_to_rad(noise.attitude_constant_deg) * normals(constant);
  const double attitude = base::deg_to_rad(noise.attitude_deg);
  Vec3 walk = Vec3::Zero(), turn = attitude * normals(turning);
  std::vector<NoisyPose> result;
  result.reserve(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double step = i > 0 ? times_s[i] - times_s[i - 1] : 0.0;
    if (i > 0) {
      walk +=
          std::sqrt(std::max(0.0, step)) *
          normals(walking).cwiseProduct(Vec3(noise.walk_xy_m_sqrt_s, noise.walk_xy_m_sqrt_s, noise.walk_z_m_sqrt_s));
      const double keep =
          noise.attitude_correlation_s > 0.0 ? std::exp(-std::max(0.0, step) / noise.attitude_correlation_s) : 0.0;
      turn = keep * turn + std::sqrt(1.0 - keep * keep) * attitude * normals(turning);
    }
    const Vec3 jump = normals(white).cwiseProduct(Vec3(noise.white_xy_m, noise.white_xy_m, noise.white_z_m));
    NoisyPose pose;
    pose.T_world_camera.translation = poses[i].translation + bias + walk + jump;
    pose.T_world_camera.rotation = poses[i].rotation * small_rotation(mounted + turn);
    const double elapsed = times_s[i] - times_s[0];
    const auto total = [elapsed](double w, double c, double r) { return std::sqrt(w * w + c * c + r * r * elapsed); };
    pose.sigma_xy_m = total(noise.white_xy_m, noise.constant_xy_m, noise.walk_xy_m_sqrt_s);
    pose.sigma_z_m = total(noise.white_z_m, noise.constant_z_m, noise.walk_z_m_sqrt_s);
    pose.sigma_rot_deg = std::hypot(noise.attitude_deg, noise.attitude_constant_deg);
    result.push_back(pose);
  }
  return result;
}

}  // namespace cairn::simulation
