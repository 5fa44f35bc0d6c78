#include "ground/drive.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "ground/costmap.hpp"
#include "ground/path.hpp"

namespace cairn::ground {
namespace {

using geometry::Grid;
using geometry::Vec2;

constexpr double kNanoseconds = 1e9;
constexpr double kProgress_m = 0.15;  // less is no progress
constexpr double kFollow_m = 2.0;     // the nearest point of the path is looked for this far on
constexpr double kLeastRise_m = 0.5;  // smaller changes of cost ask for no new path

double seconds(std::int64_t from_ns, std::int64_t to_ns) {
  return static_cast<double>(to_ns - from_ns) / kNanoseconds;
}

// Nearest drivable cell within reach of a point; ties go to the first in rows and columns.
std::optional<Cell> drivable_near(const Grid<std::uint8_t>& cost, const Vec2& p, double reach,
                                  const RouteOptions& options) {
  const auto& g = cost.geometry;
  const auto middle = g.cell_at(p);
  if (!middle) return std::nullopt;
  if (drivable(cost.at(middle->first, middle->second), options)) return middle;
  const auto span = static_cast<std::size_t>(std::ceil(reach / g.cell));
  const auto low = [span](std::size_t at) { return at > span ? at - span : 0; };
  std::optional<Cell> best;
  double least = reach;
  for (std::size_t r = low(middle->first); r <= std::min(g.rows - 1, middle->first + span); ++r)
    for (std::size_t c = low(middle->second); c <= std::min(g.columns - 1, middle->second + span); ++c) {
      const double distance = (g.centre(r, c) - p).norm();
      if (distance >= least || !drivable(cost.at(r, c), options)) continue;
      least = distance;
      best = Cell(r, c);
    }
  return best;
}

}  // namespace

void DriverOptions::visit(base::OptionVisitor& v) {
  route.visit(v);
  visit_driving(v);
}

void DriverOptions::visit_driving(base::OptionVisitor& v) {
  vehicle.visit(v);
  local.visit(v);
  v.flag("drive-smooth", smooth, "straighten global paths before they are followed");
  v.real("goal-tolerance-m", goal_tolerance_m, 0.01, 100.0, "the goal is reached within this distance");
  v.real("replan-period-s", replan_period_s, 0.0, 1e6, "a new path is looked for at least this often; 0 = when needed");
  v.real("replan-interval-s", replan_interval_s, 0.0, 1e6, "new paths are looked for no more often than this");
  v.real("gain", gain, 0.0, 1.0, "share that a new path must save to be taken");
  v.real("rise", rise, 0.0, 100.0, "share by which the path may become costlier before another is looked for");
  v.real("off-path-m", off_path_m, 0.05, 100.0, "distance beside the path from which another is looked for");
  v.real("snap-m", snap_m, 0.0, 100.0, "reach of the nearest free cell where an end stands on blocked ground");
  v.real("stuck-s", stuck_s, 0.5, 1e6, "time without progress before a recovery");
  v.real("recovery-s", recovery_s, 0.1, 1e6, "length of a recovery");
}

std::string_view name_of(DriveStatus status) {
  switch (status) {
    case DriveStatus::driving: return "driving";
    case DriveStatus::recovering: return "recovering";
    case DriveStatus::blocked: return "blocked";
    case DriveStatus::arrived: return "arrived";
  }
  return "";
}

Driver::Driver(const Vec2& goal, const DriverOptions& options) : goal_(goal), options_(options) {
  if (!goal.allFinite()) throw base::Error(base::ErrorCode::invalid_argument, "the goal is not finite");
  base::validate(base::bind_options(options_), "drive");
}

Driver::Ahead Driver::ahead(const Grid<std::uint8_t>& cost) const {
  Ahead left;
  double before = 0.0;
  for (std::size_t i = at_; i < path_.size(); ++i) {
    const auto cell = cost.geometry.cell_at(path_[i]);
    const std::uint8_t value = cell ? cost.at(cell->first, cell->second) : kUnknown;
    // All of the path was drivable when it was planned.
    left.blocked = left.blocked || !drivable(value, options_.route);
    const double factor = step_factor(value, options_.route);
    if (i > at_) left.weighted_m += (path_[i] - path_[i - 1]).norm() * 0.5 * (before + factor);
    before = factor;
  }
  return left;
}

std::string Driver::need(std::int64_t now_ns, const PlanarPose& pose, const Ahead& left) const {
  if (!planned_ns_) return "first";
  const double since = seconds(*planned_ns_, now_ns);
  if (since < options_.replan_interval_s) return "";
  if (path_.empty()) return "first";
  if (left.blocked) return "blocked";
  if ((path_[at_] - pose.position).norm() > options_.off_path_m) return "off_path";
  if (left.weighted_m > to_go_[at_] * (1.0 + options_.rise) + kLeastRise_m) return "costlier";
  if (options_.replan_period_s > 0.0 && since >= options_.replan_period_s) return "cheaper";
  return "";
}

void Driver::plan(std::int64_t now_ns, const PlanarPose& pose, const Grid<std::uint8_t>& cost, const Ahead& left,
                  const std::string& need, DriveTick& tick, base::RunContext& ctx) {
  planned_ns_ = now_ns;
  ++plans_;
  no_path_.clear();
  const auto& g = cost.geometry;
  const auto start = drivable_near(cost, pose.position, options_.snap_m, options_.route);
  const auto goal = drivable_near(cost, goal_, options_.snap_m, options_.route);
  if (!start) no_path_ = g.cell_at(pose.position) ? "start_blocked" : "start_outside";
  else if (!goal) no_path_ = g.cell_at(goal_) ? "goal_blocked" : "goal_outside";
  Route route;
  if (no_path_.empty()) {
    route = find_route(cost, *start, *goal, options_.route, ctx);
    expansions_ += route.expansions;
    if (!route.found) no_path_ = route.reason;
  }
  if (!no_path_.empty()) {
    path_.clear();
    return;
  }
  std::vector<Vec2> path = route.path;
  if (options_.smooth) path = with_points(smoothed(cost, path, options_.route), g.cell);
  std::vector<double> to_go(path.size(), 0.0);
  const auto factor = [&](const Vec2& p) {
    const auto cell = g.cell_at(p);
    return step_factor(cell ? cost.at(cell->first, cell->second) : kUnknown, options_.route);
  };
  for (std::size_t i = path.size(); i-- > 1;)
    to_go[i - 1] = to_go[i] + (path[i] - path[i - 1]).norm() * 0.5 * (factor(path[i]) + factor(path[i - 1]));

  const bool may_keep = !path_.empty() && !left.blocked && (need == "cheaper" || need == "costlier");
  if (may_keep && to_go.front() > left.weighted_m * (1.0 - options_.gain)) {
    // The old path stays. What is left of it costs more now than when it was planned: the next rise counts from here.
    if (need == "costlier") {
      const double scale = left.weighted_m / std::max(to_go_[at_], 1e-9);
      for (double& weighted : to_go_) weighted *= scale;
    }
    return;
  }
  if (had_path_) ++replans_;
  had_path_ = true;
  tick.replanned = true;
  tick.reason = need;
  path_ = std::move(path);
  to_go_ = std::move(to_go);
  at_ = 0;
}

void Driver::follow(const PlanarPose& pose) {
  double least = (path_[at_] - pose.position).norm(), way = 0.0;
  for (std::size_t i = at_ + 1; i < path_.size() && way < kFollow_m; ++i) {
    way += (path_[i] - path_[i - 1]).norm();
    const double distance = (path_[i] - pose.position).norm();
    if (distance > least) continue;
    least = distance;
    at_ = i;
  }
}

bool Driver::stuck(std::int64_t now_ns, const PlanarPose& pose) {
  if (!progress_ || (pose.position - progress_->position).norm() > kProgress_m) {
    progress_ = pose;
    progress_ns_ = now_ns;
  }
  return seconds(progress_ns_, now_ns) > options_.stuck_s;
}

DriveVelocity Driver::recover(const PlanarPose& pose, const DriveVelocity& velocity,
                              const Grid<std::uint8_t>& cost) const {
  const double tick = 1.0 / options_.local.rate_hz;
  // Every second recovery backs off, where the ground behind is free.
  const DriveVelocity back{-options_.vehicle.max_reverse_m_s, 0.0};
  if (recoveries_ % 2 == 0 && options_.vehicle.max_reverse_m_s > 0.0 &&
      safe_arc(pose, back, 1.0, cost, options_.route.allow_unknown, options_.vehicle))
    return approach(velocity, back, tick, options_.vehicle);
  if (path_.empty()) return approach(velocity, {}, tick, options_.vehicle);
  const std::size_t on =
      std::min(path_.size() - 1, at_ + static_cast<std::size_t>(options_.local.lookahead_m / cost.geometry.cell));
  const Vec2 way = path_[on] - pose.position;
  const double error = wrapped(std::atan2(way.y(), way.x()) - pose.yaw);
  return approach(velocity,
                  {0.0, std::clamp(2.0 * error, -options_.vehicle.max_turn_rad_s, options_.vehicle.max_turn_rad_s)},
                  tick, options_.vehicle);
}

DriveTick Driver::tick(std::int64_t now_ns, const PlanarPose& pose, const DriveVelocity& velocity,
                       const Grid<std::uint8_t>& cost, base::RunContext& ctx) {
  DriveTick tick;
  const double period = 1.0 / options_.local.rate_hz;
  if (arrived_ || (pose.position - goal_).norm() <= options_.goal_tolerance_m) {
    arrived_ = true;
    tick.status = DriveStatus::arrived;
    tick.command = approach(velocity, {}, period, options_.vehicle);
    return tick;
  }
  if (!path_.empty()) follow(pose);
  Ahead left = path_.empty() ? Ahead{} : ahead(cost);
  std::string why = need(now_ns, pose, left);
  const bool is_stuck = !path_.empty() && !recovery_ns_ && stuck(now_ns, pose);
  if (is_stuck) why = "stuck";
  if (!why.empty()) plan(now_ns, pose, cost, left, why, tick, ctx);
  if (path_.empty()) {
    tick.status = DriveStatus::blocked;
    tick.reason = no_path_;
    tick.command = approach(velocity, {}, period, options_.vehicle);
    progress_.reset();
    recovery_ns_.reset();
    return tick;
  }
  if (is_stuck) {
    recovery_ns_ = now_ns;
    ++recoveries_;
  }
  if (recovery_ns_ && seconds(*recovery_ns_, now_ns) < options_.recovery_s) {
    tick.status = DriveStatus::recovering;
    tick.command = recover(pose, velocity, cost);
    progress_.reset();
    return tick;
  }
  recovery_ns_.reset();
  const auto choice = choose_velocity(pose, velocity, cost, std::span(path_).subspan(at_), options_.route.allow_unknown,
                                      options_.vehicle, options_.local);
  tick.command = choice.velocity;
  return tick;
}

}  // namespace cairn::ground
