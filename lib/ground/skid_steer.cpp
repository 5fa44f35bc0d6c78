#include "ground/skid_steer.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cairn::ground {
namespace {

// Below this turn rate the arc's closed form loses digits; the series is exact to rounding there.
constexpr double kStraight_rad = 1e-6;

double toward(double from, double to, double step) {
  return from + std::clamp(to - from, -step, step);
}

}  // namespace

WheelSpeeds wheel_speeds(const DriveVelocity& velocity, const SkidSteerOptions& options) {
  const double side = 0.5 * options.track_ratio * options.track_m * velocity.turn_rad_s;
  return {velocity.forward_m_s - side, velocity.forward_m_s + side};
}

DriveVelocity velocity_of(const WheelSpeeds& wheels, const SkidSteerOptions& options) {
  return {0.5 * (wheels.left_m_s + wheels.right_m_s),
          (wheels.right_m_s - wheels.left_m_s) / (options.track_ratio * options.track_m)};
}

DriveVelocity within_limits(const DriveVelocity& wanted, const SkidSteerOptions& options) {
  DriveVelocity cut{std::clamp(wanted.forward_m_s, -options.max_reverse_m_s, options.max_speed_m_s),
                    std::clamp(wanted.turn_rad_s, -options.max_turn_rad_s, options.max_turn_rad_s)};
  const WheelSpeeds wheels = wheel_speeds(cut, options);
  const double fastest = std::max(std::abs(wheels.left_m_s), std::abs(wheels.right_m_s));
  if (fastest > options.max_wheel_speed_m_s) {
    const double scale = options.max_wheel_speed_m_s / fastest;
    cut.forward_m_s *= scale;
    cut.turn_rad_s *= scale;
  }
  return cut;
}

DriveVelocity approach(const DriveVelocity& current, const DriveVelocity& wanted, double dt,
                       const SkidSteerOptions& options) {
  const DriveVelocity target = within_limits(wanted, options);
  DriveVelocity next;
  const bool brakes =
      std::abs(target.forward_m_s) < std::abs(current.forward_m_s) || target.forward_m_s * current.forward_m_s < 0.0;
  next.forward_m_s = toward(current.forward_m_s, target.forward_m_s,
                            dt * (brakes ? options.max_braking_m_s2 : options.max_acceleration_m_s2));
  next.turn_rad_s = toward(current.turn_rad_s, target.turn_rad_s, dt * options.max_turn_acceleration_rad_s2);
  return next;
}

PlanarPose moved(const PlanarPose& pose, const DriveVelocity& velocity, double dt) {
  const double angle = velocity.turn_rad_s * dt, way = velocity.forward_m_s * dt;
  // Chord of the arc: way * sin(a/2)/(a/2), in the mean direction.
  const double half = 0.5 * angle;
  const double chord = std::abs(half) < kStraight_rad ? way * (1.0 - half * half / 6.0) : way * std::sin(half) / half;
  const double direction = pose.yaw + half;
  return {pose.position + chord * geometry::Vec2(std::cos(direction), std::sin(direction)), wrapped(pose.yaw + angle)};
}

double braking_distance(double speed_m_s, const SkidSteerOptions& options) {
  return speed_m_s * speed_m_s / (2.0 * options.max_braking_m_s2);
}

double wrapped(double angle) {
  return std::remainder(angle, 2.0 * std::numbers::pi);
}

}  // namespace cairn::ground
