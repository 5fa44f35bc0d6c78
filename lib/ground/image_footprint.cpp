#include "ground/image_footprint.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "camera/projection.hpp"

namespace cairn::ground {
namespace {

using geometry::Ring;
using geometry::Vec2;
using geometry::Vec3;

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Side of p on the line a b: 0 within rounding, so that pieces of one straight side do not seem to cross.
double side_of(const Vec2& a, const Vec2& b, const Vec2& p) {
  const double value = cross(b - a, p - a);
  constexpr double kRounding = 1e-10;
  return std::abs(value) <= kRounding * (b - a).norm() * (p - a).norm() ? 0.0 : value;
}

bool meet(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const double c1 = side_of(a, b, c), d1 = side_of(a, b, d), a1 = side_of(c, d, a), b1 = side_of(c, d, b);
  if (c1 * d1 < 0.0 && a1 * b1 < 0.0) return true;
  const auto on = [](const Vec2& p, const Vec2& q, const Vec2& x, double side) {
    return side == 0.0 && x.x() >= std::min(p.x(), q.x()) && x.x() <= std::max(p.x(), q.x()) &&
           x.y() >= std::min(p.y(), q.y()) && x.y() <= std::max(p.y(), q.y());
  };
  return on(a, b, c, c1) || on(a, b, d, d1) || on(c, d, a, a1) || on(c, d, b, b1);
}

Ring counter_clockwise(Ring ring) {
  if (geometry::signed_area(ring) < 0.0) std::reverse(ring.begin(), ring.end());
  return ring;
}

// The part of a convex ring where normal . (x, y, up) >= offset.
Ring clipped(const Ring& ring, const Vec3& normal, double offset, double up) {
  Ring kept;
  const auto value = [&](const Vec2& p) { return normal.dot(Vec3(p.x(), p.y(), up)) - offset; };
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec2 &a = ring[i], &b = ring[(i + 1) % ring.size()];
    const double va = value(a), vb = value(b);
    if (va >= 0.0) kept.push_back(a);
    if ((va >= 0.0) != (vb >= 0.0)) kept.emplace_back(a + (b - a) * (va / (va - vb)));
  }
  return kept;
}

Ring without_repeats(const Ring& ring) {
  constexpr double kSame = 1e-9;  // m
  Ring kept;
  for (const Vec2& p : ring)
    if (kept.empty() || (p - kept.back()).norm() > kSame) kept.push_back(p);
  while (kept.size() > 1 && (kept.front() - kept.back()).norm() <= kSame) kept.pop_back();
  return kept;
}

// Disc about the camera's nadir, cut by the four planes through neighbouring corner rays.
Ring convex_footprint(const survey::Camera& camera, const geometry::RigidTransform& pose, double up, double max_range) {
  constexpr int kAround = 48;
  Ring ring;
  for (int i = 0; i < kAround; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kAround;
    ring.emplace_back(pose.translation.head<2>() + max_range * Vec2(std::cos(angle), std::sin(angle)));
  }
  const auto w = static_cast<double>(camera.width_px), h = static_cast<double>(camera.height_px);
  std::array<Vec3, 4> corners;
  const std::array<Vec2, 4> pixels{Vec2(0, 0), Vec2(w, 0), Vec2(w, h), Vec2(0, h)};
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const auto ray = camera::pixel_ray(camera, pose, pixels.at(i));
    if (!ray) return {};
    corners.at(i) = ray->direction;
  }
  const Vec3 axis = pose.rotation.col(2);
  if (!(pose.translation.z() > up)) return {};
  for (std::size_t i = 0; i < corners.size() && ring.size() >= 3; ++i) {
    Vec3 normal = corners.at(i).cross(corners.at((i + 1) % corners.size()));
    if (normal.dot(axis) < 0.0) normal = -normal;
    ring = clipped(ring, normal, normal.dot(pose.translation), up);
  }
  // The cone's mirror image behind the camera is cut off as well, as all four normals look forward. Rounding of
  // vertices that nearly coincide could make the ring not convex: the hull is.
  ring = geometry::convex_hull(std::move(ring));
  constexpr double kLeastArea = 1e-3;  // m^2; slivers show nothing
  return ring.size() < 3 || geometry::signed_area(ring) < kLeastArea ? Ring{} : ring;
}

}  // namespace

bool is_simple(const Ring& ring) {
  const std::size_t n = ring.size();
  if (n < 3) return false;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j + 1 == n) continue;
      if (meet(ring[i], ring[i + 1], ring[j], ring[(j + 1) % n])) return false;
    }
  return true;
}

Ring image_footprint(const survey::Camera& camera, const geometry::RigidTransform& T_world_camera, const Ground& ground,
                     double max_range, double step, int per_side) {
  const auto w = static_cast<double>(camera.width_px), h = static_cast<double>(camera.height_px);
  if (!T_world_camera.rotation.allFinite() || !T_world_camera.translation.allFinite()) return {};
  const std::array<Vec2, 4> corners{Vec2(0, 0), Vec2(w, 0), Vec2(w, h), Vec2(0, h)};
  const Vec2 nadir = T_world_camera.translation.head<2>();
  Ring ring;
  bool whole = true;
  for (std::size_t side = 0; side < corners.size() && whole; ++side)
    for (int i = 0; i < per_side && whole; ++i) {
      const Vec2 pixel =
          corners.at(side) + (corners.at((side + 1) % 4) - corners.at(side)) * (static_cast<double>(i) / per_side);
      const auto ray = camera::pixel_ray(camera, T_world_camera, pixel);
      const auto hit = ray ? cast_on_ground(*ray, ground, 0.0, 2.0 * max_range, step) : std::nullopt;
      whole = hit && (hit->point.head<2>() - nadir).norm() <= max_range;
      if (whole) ring.emplace_back(hit->point.head<2>());
    }
  if (whole) {
    ring = without_repeats(ring);
    if (is_simple(ring)) return counter_clockwise(std::move(ring));
  }
  const auto middle = camera::pixel_ray(camera, T_world_camera, Vec2(0.5 * w, 0.5 * h));
  const auto hit = middle ? cast_on_ground(*middle, ground, 0.0, 2.0 * max_range, step) : std::nullopt;
  const double up = hit ? hit->point.z() : ground.up(nadir.x(), nadir.y());
  return convex_footprint(camera, T_world_camera, up, max_range);
}

double depth_inside(const Ring& ring, const Vec2& p) {
  if (ring.size() < 3) return -std::numeric_limits<double>::infinity();
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec2 &a = ring[i], d = ring[(i + 1) % ring.size()] - a;
    const double length = d.squaredNorm();
    const double t = length > 0.0 ? std::clamp(d.dot(p - a) / length, 0.0, 1.0) : 0.0;
    nearest = std::min(nearest, (a + t * d - p).norm());
  }
  return geometry::contains(ring, p) ? nearest : -nearest;
}

}  // namespace cairn::ground
