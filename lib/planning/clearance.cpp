#include "planning/clearance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "planning/minimum_snap.hpp"

namespace cairn::planning {
namespace {

using geometry::Vec2;
using geometry::Vec3;

constexpr double kStep = 0.5;  // m between the points of a leg that are tested

}  // namespace

std::optional<double> least_up(const Vec2& p, const SurfaceHeights& surface, const ClearanceOptions& options) {
  auto highest = surface.highest(p, options.clearance_radius_m);
  if (!highest) highest = surface.highest(p, options.unknown_reach_m);
  if (!highest) return std::nullopt;
  return *highest + options.clearance_m;
}

std::vector<Vec3> safe_leg(const Vec3& a, const Vec3& b, const SurfaceHeights& surface,
                           const ClearanceOptions& options) {
  const double length = (b - a).norm(), flat = (b - a).head<2>().norm();
  const double unknown = surface.highest() + options.clearance_m;
  const auto pieces = static_cast<std::size_t>(std::ceil(std::max(length, kStep) / kStep));
  double needed = -std::numeric_limits<double>::infinity();
  bool straight = true;
  for (std::size_t i = 0; i <= pieces; ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(pieces);
    const Vec3 p = a + t * (b - a);
    // Between two samples nothing is missed: each looks half a step farther.
    auto highest = surface.highest(p.head<2>(), options.clearance_radius_m + 0.5 * kStep);
    if (!highest) highest = surface.highest(p.head<2>(), options.unknown_reach_m);
    const bool end = i == 0 || i == pieces;
    const double least = highest ? *highest + options.clearance_m : unknown;
    if (!end) straight = straight && p.z() >= least;
    needed = std::max(needed, least);
  }
  if (straight || flat < 1e-6) return {};
  const double up = std::max({needed, a.z(), b.z()});
  std::vector<Vec3> via;
  if (up > a.z()) via.emplace_back(a.x(), a.y(), up);
  if (up > b.z()) via.emplace_back(b.x(), b.y(), up);
  return via;
}

LeastClearance least_clearance(std::span<const survey::PolynomialSegment> trajectory, const SurfaceHeights& surface,
                               double radius, double step) {
  LeastClearance least;
  least.height_m = std::numeric_limits<double>::infinity();
  for (const auto& segment : trajectory) {
    // The chord through eleven points is close enough to the length to set the step by.
    double length = 0.0;
    Vec3 before = evaluate(segment, 0.0).head<3>();
    for (int i = 1; i <= 10; ++i) {
      const Vec3 p = evaluate(segment, segment.duration_s * i / 10.0).head<3>();
      length += (p - before).norm();
      before = p;
    }
    const auto pieces = static_cast<std::size_t>(std::ceil(length / step)) + 1;
    for (std::size_t i = 0; i <= pieces; ++i) {
      const double t = segment.duration_s * static_cast<double>(i) / static_cast<double>(pieces);
      const Vec3 p = evaluate(segment, t).head<3>();
      ++least.samples;
      const auto highest = surface.highest(p.head<2>(), radius);
      if (!highest) {
        ++least.unknown;
        continue;
      }
      if (p.z() - *highest >= least.height_m) continue;
      least.height_m = p.z() - *highest;
      least.at = p;
    }
  }
  return least;
}

}  // namespace cairn::planning
