#include "ground/dwa.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "ground/costmap.hpp"

namespace cairn::ground {
namespace {

using geometry::Grid;
using geometry::Vec2;

// Slower than this a vehicle turns on the spot: its arc is one cell.
constexpr double kStanding_m_s = 1e-3;
// Points of the path nearer to one another than this are passed over; the way left is interpolated between.
constexpr double kPathStep_m = 0.1;

// What is left of the path within the window, with the way still to go at each point.
class Way {
 public:
  Way(std::span<const Vec2> path, const Vec2& from, double window) {
    double travelled = 0.0, kept = 0.0;
    for (std::size_t i = 0; i < path.size(); ++i) {
      if (i > 0) travelled += (path[i] - path[i - 1]).norm();
      const bool last = i + 1 == path.size() || (path[i + 1] - from).norm() > window;
      if (i == 0 || last || travelled - kept >= kPathStep_m) {
        points_.push_back(path[i]);
        left_.push_back(travelled);
        kept = travelled;
      }
      if (last) break;
    }
    for (double& left : left_) left = travelled - left;
  }

  struct Nearest {
    double cost_m = std::numeric_limits<double>::infinity();  // way left plus what lies beside
    std::size_t segment = 0;
    double left_m = 0.0;
  };
  [[nodiscard]] Nearest nearest(const Vec2& p, double off_path) const {
    Nearest best{off_path * (p - points_[0]).norm() + left_[0], 0, left_[0]};
    for (std::size_t i = 0; i + 1 < points_.size(); ++i) {
      const Vec2 along = points_[i + 1] - points_[i];
      const double share = std::clamp((p - points_[i]).dot(along) / along.squaredNorm(), 0.0, 1.0);
      const double left = left_[i] + share * (left_[i + 1] - left_[i]);
      const double cost = off_path * (points_[i] + share * along - p).norm() + left;
      if (cost < best.cost_m) best = {cost, i, left};
    }
    return best;
  }
  // The point `ahead` metres after one that has left_m to go.
  [[nodiscard]] Vec2 point_ahead(const Nearest& from, double ahead) const {
    const double wanted = std::max(0.0, from.left_m - ahead);
    std::size_t i = from.segment;
    while (i + 2 < points_.size() && left_[i + 1] > wanted) ++i;
    if (i + 1 >= points_.size()) return points_[i];
    const double share = std::clamp((left_[i] - wanted) / std::max(left_[i] - left_[i + 1], 1e-9), 0.0, 1.0);
    return points_[i] + share * (points_[i + 1] - points_[i]);
  }

 private:
  std::vector<Vec2> points_;
  std::vector<double> left_;
};

struct Arc {
  bool safe = false;
  double mean_cost = 0.0;  // 0..252 and above
  PlanarPose end;
};

class Window {
 public:
  Window(const Grid<std::uint8_t>& cost, bool allow_unknown) : cost_(cost), allow_unknown_(allow_unknown) {}

  [[nodiscard]] std::uint8_t cost_at(const Vec2& p) const {
    const auto cell = cost_.geometry.cell_at(p);
    const std::uint8_t value = cell ? cost_.at(cell->first, cell->second) : kUnknown;
    return value == kUnknown && allow_unknown_ ? 0 : value;
  }

  // Follows a velocity for the horizon, and then brakes along the same arc.
  [[nodiscard]] Arc follow(const PlanarPose& from, const DriveVelocity& velocity, const SkidSteerOptions& vehicle,
                           double horizon) const {
    Arc arc{false, 0.0, moved(from, velocity, horizon)};
    const std::uint8_t here = cost_at(from.position);
    const double speed = std::abs(velocity.forward_m_s);
    if (speed < kStanding_m_s) {
      // A round vehicle that turns on the spot touches nothing new.
      arc.safe = true;
      arc.mean_cost = std::min<double>(here, kSteepestFree);
      return arc;
    }
    const double time = horizon + braking_distance(speed, vehicle) / speed;
    const auto steps = static_cast<int>(std::ceil(time * speed / cost_.geometry.cell)) + 1;
    const double dt = time / steps;
    PlanarPose pose = from;
    std::uint8_t before = here;
    double sum = 0.0;
    for (int i = 0; i < steps; ++i) {
      pose = moved(pose, velocity, dt);
      const std::uint8_t value = cost_at(pose.position);
      // Blocked ground may be left, never entered.
      if (value >= kInscribed && (before < kInscribed || value > before)) return arc;
      before = value;
      sum += std::min<double>(value, kSteepestFree);
    }
    arc.safe = before < kInscribed;
    arc.mean_cost = sum / steps;
    return arc;
  }

 private:
  const Grid<std::uint8_t>& cost_;
  bool allow_unknown_;
};

}  // namespace

bool safe_arc(const PlanarPose& pose, const DriveVelocity& velocity, double seconds, const Grid<std::uint8_t>& cost,
              bool allow_unknown, const SkidSteerOptions& vehicle) {
  return Window(cost, allow_unknown).follow(pose, velocity, vehicle, seconds).safe;
}

DwaChoice choose_velocity(const PlanarPose& pose, const DriveVelocity& current, const Grid<std::uint8_t>& cost,
                          std::span<const Vec2> path, bool allow_unknown, const SkidSteerOptions& vehicle,
                          const DwaOptions& options) {
  DwaChoice choice;
  choice.score_m = std::numeric_limits<double>::infinity();
  const double tick = 1.0 / options.rate_hz;
  if (path.empty()) {
    choice.velocity = approach(current, {}, tick, vehicle);
    return choice;
  }
  const Window window(cost, allow_unknown);
  const Way way(path, pose.position, options.window_m);
  // The arc must stay within the window.
  const double horizon = std::min(options.horizon_s, options.window_m / vehicle.max_speed_m_s);

  // Reachable within one tick.
  const double slowest = approach(current, {}, tick, vehicle).forward_m_s;
  const double fastest = approach(current, {vehicle.max_speed_m_s, 0.0}, tick, vehicle).forward_m_s;
  const double turn_step = tick * vehicle.max_turn_acceleration_rad_s2;
  const double right = std::max(-vehicle.max_turn_rad_s, current.turn_rad_s - turn_step);
  const double left = std::min(vehicle.max_turn_rad_s, current.turn_rad_s + turn_step);

  const auto sample = [](double lo, double hi, std::int64_t i, std::int64_t count) {
    return lo + (hi - lo) * static_cast<double>(i) / static_cast<double>(count - 1);
  };
  const auto consider = [&](const DriveVelocity& wanted) {
    const DriveVelocity candidate = within_limits(wanted, vehicle);
    ++choice.candidates;
    const Arc arc = window.follow(pose, candidate, vehicle, horizon);
    if (!arc.safe) return;
    ++choice.safe;
    const auto nearest = way.nearest(arc.end.position, options.off_path);
    const Vec2 ahead = way.point_ahead(nearest, options.lookahead_m) - arc.end.position;
    // At the end of the path there is no direction left to judge.
    const double weight = std::min(1.0, ahead.norm() / options.lookahead_m);
    const double error = std::abs(wrapped(std::atan2(ahead.y(), ahead.x()) - arc.end.yaw)) / std::numbers::pi;
    const double score =
        nearest.cost_m + options.heading_m * weight * error + options.cost_m * arc.mean_cost / kSteepestFree;
    if (score < choice.score_m) {
      choice.score_m = score;
      choice.velocity = candidate;
      choice.found = true;
    }
  };
  for (std::int64_t s = 0; s < options.speed_samples; ++s) {
    const double speed = std::max(0.0, sample(slowest, fastest, s, options.speed_samples));
    for (std::int64_t t = 0; t < options.turn_samples; ++t)
      consider({speed, sample(right, left, t, options.turn_samples)});
    if (right < 0.0 && left > 0.0) consider({speed, 0.0});
  }
  if (!choice.found) {
    choice.velocity = approach(current, {}, tick, vehicle);
    return choice;
  }
  constexpr int kDrawn = 20;
  for (int i = 0; i <= kDrawn; ++i) choice.arc.push_back(moved(pose, choice.velocity, horizon * i / kDrawn).position);
  return choice;
}

}  // namespace cairn::ground
