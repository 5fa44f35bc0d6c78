// Trajectories that keep their limits.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "base/options.hpp"
#include "planning/minimum_snap.hpp"
#include "survey/mission.hpp"

namespace cairn::planning {

struct TrajectoryOptions {
  // paper: the durations of the published planner (nominal_duration), speed and acceleration only reported.
  // robust: durations are scaled until the limits hold.
  std::string mode = "robust";
  double max_speed_m_s = 1.0;          // paper A, A25
  double max_acceleration_m_s2 = 1.0;  // paper A, A25: roll and pitch stay small
  double max_yaw_rate_deg_s = 45.0;    // the paper gives none; stops motion blur and gimbal lag when turning
  std::int64_t rounds = 24;            // of shifting time between segments before all are scaled together

  void visit(base::OptionVisitor& v) {
    v.choice("mode", mode, {"paper", "robust"}, "robust enforces the limits; paper reports what its durations give");
    v.real("max-speed-m-s", max_speed_m_s, 0.01, 100.0, "largest speed of the trajectory, m/s");
    v.real("max-acceleration-m-s2", max_acceleration_m_s2, 0.01, 100.0, "largest acceleration, m/s^2");
    v.real("max-yaw-rate-deg-s", max_yaw_rate_deg_s, 0.1, 720.0, "largest rate of turn about the vertical, deg/s");
    v.integer("trajectory-rounds", rounds, 0, 1000, "rounds of shifting time between the segments");
  }
};

// Duration of a segment over distance d [m] (or 4-D norm with yaw in rad, D33) by the published planner:
// 2 d/v (1 + 6.5 (v/a) exp(-2 d/v)), s.
[[nodiscard]] double nominal_duration(double d, double v, double a);

struct Peaks {
  double speed_m_s = 0.0;
  double acceleration_m_s2 = 0.0;
  double yaw_rate_deg_s = 0.0;
};

// Upper bounds, at most 1e-6 (relative) above the largest values: the squared norms are polynomials, bounded by their
// Bernstein coefficients on ever smaller pieces. Cost about 20 us a segment.
[[nodiscard]] Peaks peaks(std::span<const survey::PolynomialSegment> trajectory);

// A key of a flight; the vehicle comes to rest where `stop` is set, at the first and at the last one always.
struct FlightKey {
  Pose4 pose = Pose4::Zero();
  bool stop = false;
};

struct Flight {
  std::vector<survey::PolynomialSegment> trajectory;
  std::vector<double> key_times_s;  // one a key
  Peaks peaks;
};

// Between stops one minimum-snap trajectory.
// paper: durations of nominal_duration over the 4-D norm.
// robust: a leg from stop to stop is a straight line flown with a smooth ramp, a cruise and a ramp; other stretches get
// extra keys on long lines between keys (else a long segment beside a short one swings out), and in each round a
// segment's duration is multiplied by a power of how far it passes the limits (or stays below); then all of a stretch
// are scaled by what still lacks: with rest at both ends that changes nothing but time, so the limits hold.
// Keys closer than 1e-9 m and rad to the one before take no time.
// A stretch of one key is a pause. Throws invalid_argument for options out of range, keys that are not finite or none.
[[nodiscard]] Flight plan_flight(std::span<const FlightKey> keys, const TrajectoryOptions& options);

}  // namespace cairn::planning
