// Motion of a four-wheel skid-steer vehicle in the plane.
#pragma once

#include "base/options.hpp"
#include "geometry/pose2.hpp"
#include "geometry/vec.hpp"

namespace cairn::ground {

// Of the vehicle's centre, local ENU; yaw within -pi..pi.
using PlanarPose = geometry::Pose2;

// What the vehicle is told, or what it does, along and about its own axes.
struct DriveVelocity {
  double forward_m_s = 0.0;  // negative = backwards
  double turn_rad_s = 0.0;   // counter-clockwise
  friend bool operator==(const DriveVelocity&, const DriveVelocity&) = default;
};

// Paper B names no limits (B14); the defaults are a Clearpath Jackal's size at half its speed.
struct SkidSteerOptions {
  double max_speed_m_s = 1.0;          // forward
  double max_reverse_m_s = 0.3;        // backward, in recoveries only
  double max_turn_rad_s = 1.2;         // either way
  double max_acceleration_m_s2 = 1.0;  // gaining speed
  double max_braking_m_s2 = 2.0;       // losing speed
  double max_turn_acceleration_rad_s2 = 3.0;
  double max_wheel_speed_m_s = 2.0;  // of the rim, either side
  double track_m = 0.37;             // between the left and the right wheels
  // Wheels of a skid-steer vehicle slip sideways when it turns: it turns as a two-wheeled one whose track is this many
  // times wider (distance between the sides' instantaneous centres of rotation; Martinez et al. 2005, Mandow et al.
  // 2007, who measured 1.5 to 2 on hard ground).
  double track_ratio = 1.5;

  void visit(base::OptionVisitor& v) {
    v.real("max-speed-m-s", max_speed_m_s, 0.05, 20.0, "greatest forward speed");
    v.real("max-reverse-m-s", max_reverse_m_s, 0.0, 20.0, "greatest backward speed, in recoveries only");
    v.real("max-turn-rad-s", max_turn_rad_s, 0.05, 20.0, "greatest turn rate");
    v.real("max-acceleration-m-s2", max_acceleration_m_s2, 0.05, 50.0, "greatest gain of speed");
    v.real("max-braking-m-s2", max_braking_m_s2, 0.05, 50.0, "greatest loss of speed");
    v.real("max-turn-acceleration-rad-s2", max_turn_acceleration_rad_s2, 0.05, 100.0, "greatest change of turn rate");
    v.real("max-wheel-speed-m-s", max_wheel_speed_m_s, 0.05, 50.0, "greatest speed of a wheel's rim");
    v.real("track-m", track_m, 0.05, 10.0, "distance between the left and the right wheels");
    v.real("track-ratio", track_ratio, 1.0, 5.0, "effective over true track: sideways slip of the wheels");
  }
};

// Rim speeds of the left and right wheels [m/s] that give a velocity: v -+ w ratio track / 2.
struct WheelSpeeds {
  double left_m_s = 0.0, right_m_s = 0.0;
};
[[nodiscard]] WheelSpeeds wheel_speeds(const DriveVelocity& velocity, const SkidSteerOptions& options);
[[nodiscard]] DriveVelocity velocity_of(const WheelSpeeds& wheels, const SkidSteerOptions& options);

// Cut to the limits of speed and turn rate; then, where a wheel would be too fast, both are scaled alike, so that the
// curvature is kept.
[[nodiscard]] DriveVelocity within_limits(const DriveVelocity& wanted, const SkidSteerOptions& options);

// What `current` becomes after dt [s, >= 0] on the way to `wanted`, within limits and accelerations.
[[nodiscard]] DriveVelocity approach(const DriveVelocity& current, const DriveVelocity& wanted, double dt,
                                     const SkidSteerOptions& options);

// Where a pose gets with a constant velocity over dt [s]: an arc, exact.
[[nodiscard]] PlanarPose moved(const PlanarPose& pose, const DriveVelocity& velocity, double dt);

// Way until standstill at full braking [m].
[[nodiscard]] double braking_distance(double speed_m_s, const SkidSteerOptions& options);

// yaw brought to -pi..pi.
[[nodiscard]] double wrapped(double angle);

}  // namespace cairn::ground
