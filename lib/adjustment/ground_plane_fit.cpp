#include "adjustment/ground_plane_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "adjustment/robust.hpp"
#include "base/angle.hpp"
#include "camera/projection.hpp"

namespace cairn::adjustment {
namespace {

using geometry::Vec2;

// Horizontal displacement per metre of drop; empty for rays at or above the horizon.
std::optional<Vec2> slope(const GroundView& view, const Vec2& pixel) {
  const auto ray = camera::pixel_ray(*view.camera, view.T_world_camera, pixel);
  constexpr double kLeastDrop = 0.1;  // about 6 degrees below the horizon
  if (!ray || !(ray->direction.z() < -kLeastDrop)) return std::nullopt;
  return Vec2(ray->direction.head<2>() / -ray->direction.z());
}

double median_norm(const std::vector<Vec2>& a, const std::vector<Vec2>& b, double z) {
  std::vector<double> norms;
  norms.reserve(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) norms.push_back((a[i] - z * b[i]).norm());
  return median(std::move(norms));
}

}  // namespace

GroundPlaneFit fit_ground_plane(const GroundView& view_a, const GroundView& view_b, std::span<const PixelMatch> matches,
                                double min_height, double max_height) {
  GroundPlaneFit fit;
  fit.median_m = std::numeric_limits<double>::infinity();
  const auto& c_a = view_a.T_world_camera.translation;
  const auto& c_b = view_b.T_world_camera.translation;
  std::vector<Vec2> a, b, slope_a, slope_b;  // X_a - X_b = a - z b
  for (const auto& match : matches) {
    const auto d_a = slope(view_a, match.a), d_b = slope(view_b, match.b);
    if (!d_a || !d_b) continue;
    a.emplace_back((c_a - c_b).head<2>() + c_a.z() * *d_a - c_b.z() * *d_b);
    b.emplace_back(*d_a - *d_b);
    slope_a.push_back(*d_a);
    slope_b.push_back(*d_b);
  }
  if (a.size() < 3 || 2 * a.size() < matches.size()) return fit;
  const double lowest = std::min(c_a.z(), c_b.z());
  const double z_min = lowest - max_height, z_max = lowest - min_height;
  constexpr int kRounds = 10;
  constexpr double kFloor = 0.05;  // m: residuals below weigh alike
  std::vector<double> weights(a.size(), 1.0);
  double z = z_max;
  for (int round = 0; round < kRounds; ++round) {
    double ab = 0.0, bb = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      ab += weights[i] * a[i].dot(b[i]);
      bb += weights[i] * b[i].squaredNorm();
    }
    z = bb > 0.0 ? std::clamp(ab / bb, z_min, z_max) : z_max;
    for (std::size_t i = 0; i < a.size(); ++i) weights[i] = 1.0 / std::max(kFloor, (a[i] - z * b[i]).norm());
  }
  fit.plane_up_m = z;
  fit.median_m = median_norm(a, b, z);
  Vec2 mean_a = Vec2::Zero(), mean_b = Vec2::Zero();
  for (std::size_t i = 0; i < a.size(); ++i) {
    mean_a += slope_a[i];
    mean_b += slope_b[i];
  }
  mean_a /= static_cast<double>(a.size());
  mean_b /= static_cast<double>(a.size());
  double dot = 0.0, cross = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Vec2 p = slope_a[i] - mean_a, q = slope_b[i] - mean_b;
    dot += p.dot(q);
    cross += p.x() * q.y() - p.y() * q.x();
  }
  fit.turn_deg = base::rad_to_deg(std::atan2(cross, dot));
  return fit;
}

}  // namespace cairn::adjustment
