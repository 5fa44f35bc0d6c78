#include "adjustment/bundle_tracks.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "camera/projection.hpp"
#include "camera/projection_jacobian.hpp"

namespace cairn::adjustment {
namespace {

using geometry::Mat3;
using geometry::Vec2;
using geometry::Vec3;

constexpr double kInfinite = std::numeric_limits<double>::infinity();

const survey::Camera& camera_of(const Views& views, std::int32_t frame) {
  return views.cameras[static_cast<std::size_t>(views.camera_of[static_cast<std::size_t>(frame)])];
}
const geometry::RigidTransform& pose_of(const Views& views, std::int32_t frame) {
  return views.poses[static_cast<std::size_t>(frame)];
}

struct RayOf {
  const TrackObservation* seen;
  Vec3 origin, direction;
};

std::optional<Vec3> nearest_point(std::span<const RayOf> rays) {
  Mat3 normal = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  const Vec3 base = rays.front().origin;
  for (const auto& ray : rays) {
    const Mat3 across = Mat3::Identity() - ray.direction * ray.direction.transpose();
    normal += across;
    right += across * (ray.origin - base);
  }
  // Parallel rays leave the smallest eigenvalue at zero; it is about half the squared angle between two rays.
  constexpr double kParallel = 1e-8;
  if (!(Eigen::SelfAdjointEigenSolver<Mat3>(normal).eigenvalues()[0] > kParallel)) return std::nullopt;
  return Vec3(base + normal.llt().solve(right));
}

bool in_front(const Views& views, const TrackObservation& seen, const Vec3& p) {
  const auto& pose = pose_of(views, seen.frame);
  return pose.rotation.col(2).dot(p - pose.translation) > 0.0;
}

// Gauss-Newton on the pixels.
Vec3 polished(const Views& views, std::span<const RayOf> rays, Vec3 p) {
  constexpr int kSteps = 5;
  for (int step = 0; step < kSteps; ++step) {
    Mat3 normal = Mat3::Zero();
    Vec3 right = Vec3::Zero();
    for (const auto& ray : rays) {
      const auto& pose = pose_of(views, ray.seen->frame);
      Vec2 pixel;
      camera::PointJacobian by_camera;
      if (!camera::project_with_jacobian(camera_of(views, ray.seen->frame),
                                         pose.rotation.transpose() * (p - pose.translation),
                                         camera::IntrinsicsSet::none, pixel, by_camera, nullptr))
        return p;
      const camera::PointJacobian j = by_camera * pose.rotation.transpose();
      normal += j.transpose() * j;
      right += j.transpose() * (ray.seen->pixel - pixel);
    }
    const Eigen::LLT<Mat3> cholesky(normal);
    if (cholesky.info() != Eigen::Success) return p;
    const Vec3 move = cholesky.solve(right);
    if (!move.allFinite()) return p;
    p += move;
    constexpr double kStill = 1e-10;  // of the distance
    if (move.norm() < kStill * (p - rays.front().origin).norm()) break;
  }
  return p;
}

double truncated_cost(const Views& views, std::span<const RayOf> rays, const Vec3& p, double gate_px) {
  double cost = 0.0;
  for (const auto& ray : rays) {
    const double error = std::min(reprojection_error(views, *ray.seen, p), gate_px);
    cost += error * error;
  }
  return cost;
}

// The best meeting of two rays, polished over those that agree with it.
std::optional<Vec3> by_pairs(const Views& views, std::span<const RayOf> rays, double gate_px) {
  constexpr std::size_t kPairs = 30;
  const std::size_t all = rays.size() * (rays.size() - 1) / 2;
  const std::size_t stride = std::max<std::size_t>(1, all / kPairs);
  std::optional<Vec3> best;
  double best_cost = kInfinite;
  std::size_t index = 0;
  for (std::size_t a = 0; a < rays.size(); ++a)
    for (std::size_t b = a + 1; b < rays.size(); ++b) {
      if (index++ % stride != 0) continue;
      const RayOf pair[] = {rays[a], rays[b]};
      const auto p = nearest_point(pair);
      if (!p) continue;
      const double cost = truncated_cost(views, rays, *p, gate_px);
      if (cost < best_cost) {
        best_cost = cost;
        best = p;
      }
    }
  if (!best) return std::nullopt;
  std::vector<RayOf> agreeing;
  for (const auto& ray : rays)
    if (reprojection_error(views, *ray.seen, *best) <= gate_px) agreeing.push_back(ray);
  if (agreeing.size() < 2) return std::nullopt;
  const Vec3 p = polished(views, agreeing, *best);
  return truncated_cost(views, rays, p, gate_px) <= best_cost ? p : *best;
}

}  // namespace

double reprojection_error(const Views& views, const TrackObservation& seen, const Vec3& p) {
  const auto pixel = camera::project_world(camera_of(views, seen.frame), pose_of(views, seen.frame), p);
  return pixel ? (*pixel - seen.pixel).norm() : kInfinite;
}

std::optional<Vec3> triangulate_track(const Views& views, const Track& track, double gate_px,
                                      std::span<const char> skip) {
  std::vector<RayOf> rays;
  for (const auto& seen : track.observations) {
    if (!skip.empty() && skip[static_cast<std::size_t>(seen.frame)] != 0) continue;
    if (const auto ray = camera::pixel_ray(camera_of(views, seen.frame), pose_of(views, seen.frame), seen.pixel))
      rays.push_back({&seen, ray->origin, ray->direction});
  }
  if (rays.size() < 2) return std::nullopt;
  auto p = nearest_point(rays);
  const auto all_in_front = [&](const Vec3& at) {
    return std::all_of(rays.begin(), rays.end(), [&](const RayOf& ray) { return in_front(views, *ray.seen, at); });
  };
  if (p && all_in_front(*p)) {
    const Vec3 moved = polished(views, rays, *p);
    if (moved.allFinite() && all_in_front(moved)) p = moved;
    double worst = 0.0;
    for (const auto& ray : rays) worst = std::max(worst, reprojection_error(views, *ray.seen, *p));
    if (worst <= gate_px || rays.size() == 2) return p;
  } else {
    p.reset();
  }
  if (rays.size() > 2 && std::isfinite(gate_px))
    if (const auto q = by_pairs(views, rays, gate_px);
        q && (!p || truncated_cost(views, rays, *q, gate_px) < truncated_cost(views, rays, *p, gate_px)))
      p = q;
  return p;
}

double parallax(const Views& views, const Track& track) {
  std::vector<Vec3> directions;
  for (const auto& seen : track.observations)
    if (seen.used) directions.push_back((track.p_world - pose_of(views, seen.frame).translation).normalized());
  double least_cosine = 1.0;
  for (std::size_t a = 0; a < directions.size(); ++a)
    for (std::size_t b = a + 1; b < directions.size(); ++b)
      least_cosine = std::min(least_cosine, directions[a].dot(directions[b]));
  return std::acos(std::max(-1.0, least_cosine));
}

void prune_tracks(const Views& views, const TrackLimits& limits, std::vector<Track>& tracks, std::vector<char>& held) {
  for (auto& track : tracks) {
    track.reason = {};
    track.used = track.placed;
    if (!track.placed) track.reason = track.observations.size() < 2 ? "seen_once" : "not_triangulated";
  }
  bool parallax_known = false;
  for (bool changed = true; changed;) {
    changed = false;
    std::vector<std::int64_t> seen_by(held.size(), 0);
    for (auto& track : tracks) {
      if (!track.used) continue;
      std::size_t frames = 0;
      for (auto& seen : track.observations) {
        seen.used = seen.used && held[static_cast<std::size_t>(seen.frame)] == 0;
        frames += seen.used ? 1U : 0U;
      }
      const bool control = track.control >= 0;
      if (frames < (control ? 1U : 2U)) {
        track.reason = track.observations.size() < 2 ? "seen_once" : "too_few_observations";
      } else if (!control && !parallax_known && parallax(views, track) < limits.min_parallax_rad) {
        track.reason = "no_parallax";
      }
      if (!track.reason.empty()) {
        track.used = false;
        changed = true;
        continue;
      }
      for (const auto& seen : track.observations)
        if (seen.used) ++seen_by[static_cast<std::size_t>(seen.frame)];
    }
    parallax_known = true;  // what is left of a point after frames are held may have less; the next round looks again
    for (std::size_t f = 0; f < held.size(); ++f) {
      if (held[f] != 0 || seen_by[f] >= limits.min_observations) continue;
      held[f] = 1;
      changed = true;
    }
  }
}

std::vector<std::int32_t> frame_groups(const std::vector<Track>& tracks, const std::vector<char>& held,
                                       std::size_t shared) {
  std::map<std::pair<std::int32_t, std::int32_t>, std::size_t> common;
  for (const auto& track : tracks) {
    if (!track.used) continue;
    for (std::size_t a = 0; a < track.observations.size(); ++a)
      for (std::size_t b = a + 1; b < track.observations.size(); ++b)
        if (track.observations[a].used && track.observations[b].used)
          ++common[std::minmax(track.observations[a].frame, track.observations[b].frame)];
  }
  std::vector<std::int32_t> parent(held.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](std::int32_t f) {
    while (parent[static_cast<std::size_t>(f)] != f) f = parent[static_cast<std::size_t>(f)];
    return f;
  };
  for (const auto& [pair, count] : common) {
    if (count < shared) continue;
    const auto a = root(pair.first), b = root(pair.second);
    parent[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }
  std::vector<std::int32_t> label(held.size());
  for (std::size_t f = 0; f < held.size(); ++f) label[f] = held[f] != 0 ? -1 : root(static_cast<std::int32_t>(f));
  return label;
}

}  // namespace cairn::adjustment
