// Legs that stay clear of the surface.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "base/options.hpp"
#include "planning/surface_heights.hpp"
#include "survey/mission.hpp"

namespace cairn::planning {

struct ClearanceOptions {
  double clearance_m = 3.0;         // least height above the highest point near the path
  double clearance_radius_m = 1.0;  // what is near: horizontal distance; must stay below the stand-off from targets
  double unknown_reach_m = 10.0;    // where nothing is known within the radius, the highest within this distance counts

  void visit(base::OptionVisitor& v) {
    v.real("clearance-m", clearance_m, 0.5, 200.0, "least height above the highest point near the path");
    v.real("clearance-radius-m", clearance_radius_m, 0.0, 100.0, "what is near the path: horizontal distance");
    v.real("unknown-reach-m", unknown_reach_m, 0.0, 1000.0,
           "over unknown ground the highest surface within this distance counts; beyond it nothing may fly");
  }
};

// Least permitted local up at a point [m]: the highest surface within the radius (where nothing is known there, within
// unknown_reach_m) + clearance; empty where nothing is known there either.
[[nodiscard]] std::optional<double> least_up(const geometry::Vec2& p, const SurfaceHeights& surface,
                                             const ClearanceOptions& options);

// Inner points of a flight from a to b that keeps the clearance: none where the straight line does; else straight up
// from a, level, and straight down to b. Both ends must keep it themselves. Where nothing is known within
// unknown_reach_m of the line, the highest known anywhere counts. Cost: length / cell x radius^2 / cell^2.
[[nodiscard]] std::vector<geometry::Vec3> safe_leg(const geometry::Vec3& a, const geometry::Vec3& b,
                                                   const SurfaceHeights& surface, const ClearanceOptions& options);

struct LeastClearance {
  double height_m = 0.0;  // above the highest surface within the radius, over all samples where it is known
  geometry::Vec3 at = geometry::Vec3::Zero();
  std::size_t samples = 0;
  std::size_t unknown = 0;  // samples with no surface within the radius
};
// Over a trajectory, a sample each `step` [m] or less. height_m is +infinity where nothing is known.
[[nodiscard]] LeastClearance least_clearance(std::span<const survey::PolynomialSegment> trajectory,
                                             const SurfaceHeights& surface, double radius, double step = 0.25);

}  // namespace cairn::planning
