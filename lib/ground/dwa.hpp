// Local motion: the dynamic window approach (Fox, Burgard & Thrun 1997) on a costmap, paper B, B14.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/options.hpp"
#include "geometry/grid.hpp"
#include "geometry/vec.hpp"
#include "ground/skid_steer.hpp"

namespace cairn::ground {

// Paper B gives the rate and the window; all else is chosen here.
struct DwaOptions {
  double rate_hz = 10.0;   // commands a second
  double window_m = 3.0;   // costs and path are looked at within this distance
  double horizon_s = 2.0;  // a candidate velocity is kept up this long
  std::int64_t speed_samples = 7, turn_samples = 17;
  // A candidate is judged by: the way left along the path from its end, where a metre beside the path counts
  // off_path metres; the heading error there; the mean cost along it.
  double off_path = 3.0;     // m a metre, > 1
  double heading_m = 0.6;    // m of way at a heading error of 180 degrees
  double cost_m = 1.5;       // m of way at mean cost 252
  double lookahead_m = 0.6;  // the heading is judged towards the path's point this far on

  void visit(base::OptionVisitor& v) {
    v.real("rate-hz", rate_hz, 1.0, 100.0, "commands a second");
    v.real("window-m", window_m, 0.5, 50.0, "local costs and path are looked at within this distance");
    v.real("horizon-s", horizon_s, 0.2, 20.0, "a candidate velocity is kept up this long");
    v.integer("speed-samples", speed_samples, 2, 101, "forward speeds tried at each command");
    v.integer("turn-samples", turn_samples, 3, 201, "turn rates tried at each command");
    v.real("off-path", off_path, 1.0, 100.0, "metres of way that a metre beside the path counts");
    v.real("heading-m", heading_m, 0.0, 100.0, "metres of way that a heading error of 180 degrees counts");
    v.real("cost-m", cost_m, 0.0, 1000.0, "metres of way that a mean cost of 252 counts");
    v.real("lookahead-m", lookahead_m, 0.05, 50.0, "the heading is judged towards the path's point this far on");
  }
};

struct DwaChoice {
  bool found = false;  // false: no candidate is safe; `velocity` then brakes to standstill
  DriveVelocity velocity;
  double score_m = 0.0;             // of the choice, less is better
  std::vector<geometry::Vec2> arc;  // where the choice leads within the horizon, local ENU, m
  std::size_t candidates = 0, safe = 0;
};

// The best velocity among those reachable within one tick (1 / rate) of `current`.
// cost: any part of the costmap that holds the window; outside it is unknown. path: what is left of the global path
// from the point nearest the vehicle on, local ENU, m, not empty.
// Safe is a candidate whose arc, followed by braking along it, meets no cell of cost >= 253 (unknown ones neither,
// unless allow_unknown). A vehicle that stands on blocked ground (an obstacle was found there, or the pose has moved)
// may leave it by the shortest: blocked cells are passed at the arc's beginning while their cost does not rise. Ties go
// to the first in order of speed, then of turn rate. Cost: samples x (arc cells + path points in the window).
[[nodiscard]] DwaChoice choose_velocity(const PlanarPose& pose, const DriveVelocity& current,
                                        const geometry::Grid<std::uint8_t>& cost, std::span<const geometry::Vec2> path,
                                        bool allow_unknown, const SkidSteerOptions& vehicle, const DwaOptions& options);

// Whether a velocity kept up for `seconds`, followed by braking along the same arc, is safe in the sense above.
[[nodiscard]] bool safe_arc(const PlanarPose& pose, const DriveVelocity& velocity, double seconds,
                            const geometry::Grid<std::uint8_t>& cost, bool allow_unknown,
                            const SkidSteerOptions& vehicle);

}  // namespace cairn::ground
