#include "fragility/hull_section.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace cairn::fragility {
namespace {

using geometry::Vec2;
using geometry::Vec3;
using Facet = std::array<std::size_t, 3>;

constexpr int kMaxWalk = 10000;  // facets; a hull of a million points is crossed in fewer

Vec3 normal_of(std::span<const Vec3> points, const Facet& f) {
  return (points[f[1]] - points[f[0]]).cross(points[f[2]] - points[f[0]]).normalized();
}

// The facet beyond the edge a -> b (its direction in the facet it is left by, whose outward unit normal is given):
// of all planes through the edge, the one that all points lie behind. Of coplanar points the farthest from the edge.
std::optional<Facet> facet_beyond(std::span<const Vec3> points, std::size_t a, std::size_t b, const Vec3& normal) {
  const Vec3 axis = (points[b] - points[a]).normalized();
  // Away from the facet, in its plane.
  const Vec3 out = axis.cross(normal);
  std::optional<std::size_t> best;
  double best_cos = 0.0, best_sin = 0.0, best_reach = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i == a || i == b) continue;
    const Vec3 d = points[i] - points[a];
    const double x = d.dot(out), y = -d.dot(normal);
    const double reach = std::hypot(x, y);
    if (!(reach > 1e-12)) continue;
    const double c = x / reach, s = y / reach;
    if (c <= 0.0 && s <= 1e-10) continue;  // the facet that is left, and what lies in its plane
    // Least angle from `out` downwards; all lie in 0..pi but for rounding.
    const double turn = best ? best_cos * s - best_sin * c : -1.0;
    constexpr double kCoplanar = 1e-10;
    if (turn < -kCoplanar || (turn <= kCoplanar && reach > best_reach)) {
      best = i;
      best_cos = c;
      best_sin = s;
      best_reach = reach;
    }
  }
  if (!best) return std::nullopt;
  return Facet{b, a, *best};
}

// Some facet of the lower hull: the lowest point, the edge that leaves it least steeply in the x-z silhouette, wrapped.
std::optional<Facet> first_facet(std::span<const Vec3> points) {
  std::size_t lowest = 0;
  for (std::size_t i = 1; i < points.size(); ++i)
    if (points[i].z() < points[lowest].z()) lowest = i;
  std::optional<std::size_t> second;
  double least = 0.0;
  for (const double sign : {1.0, -1.0}) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3 d = points[i] - points[lowest];
      if (!(sign * d.x() > 1e-12)) continue;
      const double slope = d.z() / (sign * d.x());
      if (!second || slope < least) {
        second = i;
        least = slope;
      }
    }
    if (second) break;
  }
  if (!second) return std::nullopt;
  // A supporting plane holds the edge and the y direction; its outward normal points down.
  const Vec3 edge = points[*second] - points[lowest];
  Vec3 normal = edge.cross(Vec3::UnitY());
  if (normal.z() > 0.0) normal = -normal;
  normal -= normal.dot(edge.normalized()) * edge.normalized();
  return facet_beyond(points, *second, lowest, normal.normalized());
}

double signed_area(const Vec2& a, const Vec2& b, const Vec2& c) {
  const Vec2 u = b - a, v = c - a;
  return u.x() * v.y() - u.y() * v.x();
}

}  // namespace

std::optional<RestingPose> resting_pose(std::span<const Vec3> points, const Vec3& centre) {
  if (points.size() < 4) return std::nullopt;
  auto facet = first_facet(points);
  if (!facet) return std::nullopt;
  RestingPose pose;
  bool rolling = false;
  for (int walked = 0; walked < kMaxWalk; ++walked) {
    const Vec3 normal = normal_of(points, *facet);
    if (!normal.allFinite()) return std::nullopt;
    const double depth = (points[(*facet)[0]] - centre).dot(normal);
    if (!(depth > 0.0)) return std::nullopt;
    // First the point below along z, then the foot of the perpendicular.
    Vec3 foot = centre + depth * normal;
    if (!rolling && normal.z() < -1e-9) foot = centre + Vec3(0, 0, depth / normal.z());
    // A facet that does not face down is left by its lowest side.
    if (!rolling && !(normal.z() < -1e-9)) foot = points[(*facet)[0]] - 1e6 * Vec3::UnitZ();
    int worst = -1;
    double outside = 1e-12;
    for (int k = 0; k < 3; ++k) {
      const Vec3& a = points[(*facet)[static_cast<std::size_t>(k)]];
      const Vec3& b = points[(*facet)[static_cast<std::size_t>((k + 1) % 3)]];
      const double beyond = (foot - a).dot((b - a).normalized().cross(normal));
      if (beyond > outside) {
        outside = beyond;
        worst = k;
      }
    }
    if (worst < 0) {
      if (!rolling) {
        rolling = true;
        continue;
      }
      pose.facet = *facet;
      pose.tilt = std::acos(std::clamp(-normal.z(), -1.0, 1.0));
      pose.turn = Eigen::Quaterniond::FromTwoVectors(normal, Vec3(0, 0, -1)).toRotationMatrix();
      return pose;
    }
    if (rolling) ++pose.rolls;
    facet = facet_beyond(points, (*facet)[static_cast<std::size_t>(worst)],
                         (*facet)[static_cast<std::size_t>((worst + 1) % 3)], normal);
    if (!facet) return std::nullopt;
  }
  return std::nullopt;
}

std::vector<Vec2> lower_section(std::span<const Vec3> points, const std::array<std::size_t, 3>& facet,
                                const Vec3& centre, const Vec2& along) {
  const Vec3 u(along.x(), along.y(), 0.0), side(-along.y(), along.x(), 0.0);
  // A point on the plane counts as on one side, so that every crossing goes through an edge.
  const auto left = [&](std::size_t i) { return (points[i] - centre).dot(side) >= 0.0; };
  const auto crossing = [&](std::size_t a, std::size_t b) {
    const double ya = (points[a] - centre).dot(side), yb = (points[b] - centre).dot(side);
    const double share = ya / (ya - yb);
    const Vec3 p = points[a] + share * (points[b] - points[a]) - centre;
    return Vec2(p.dot(u), p.z());
  };
  std::vector<Vec2> corners;
  for (const bool forward : {false, true}) {
    Facet f = facet;
    for (int walked = 0; walked < kMaxWalk; ++walked) {
      // Seen from outside (below), the walk leaves by the edge that goes from one side to the other.
      std::size_t leaving = 3;
      for (std::size_t k = 0; k < 3; ++k)
        if (left(f[k]) != left(f[(k + 1) % 3]) && left(f[k]) == forward) leaving = k;
      if (leaving == 3) break;
      const std::size_t a = f[leaving], b = f[(leaving + 1) % 3];
      corners.push_back(crossing(a, b));
      const auto next = facet_beyond(points, a, b, normal_of(points, f));
      if (!next) break;
      f = *next;
      const Vec3 normal = normal_of(points, f);
      // Past the vertical of the section.
      if (!normal.allFinite() || !(normal.z() < 0.0)) break;
    }
  }
  // The chain of a convex body is convex but for rounding; coincident corners go.
  std::sort(corners.begin(), corners.end(),
            [](const Vec2& a, const Vec2& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); });
  std::vector<Vec2> chain;
  constexpr double kCoincident = 1e-7;  // m
  for (const auto& p : corners) {
    if (!chain.empty() && (p - chain.back()).norm() < kCoincident) continue;
    while (chain.size() >= 2 &&
           signed_area(chain[chain.size() - 2], chain.back(), p) <= 1e-9 * (p - chain[chain.size() - 2]).norm())
      chain.pop_back();
    chain.push_back(p);
  }
  return chain;
}

}  // namespace cairn::fragility
