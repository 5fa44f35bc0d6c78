#include "pipeline/route_drive.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.hpp"
#include "ground/live_costmap.hpp"
#include "ground/obstacle_map.hpp"
#include "ground/path.hpp"

namespace cairn::pipeline {
namespace {

using geometry::Grid;
using geometry::Pose2;
using geometry::Vec2;
using ground::Occupancy;

constexpr double kFarthest_m = 25.0;  // clearances are capped here, as those of routes
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr int kMotionSteps = 5;  // of the true motion in one tick

ground::OccupancyGrid occupancy_of(const Grid<std::uint8_t>& cost) {
  ground::OccupancyGrid occupancy(cost.geometry, Occupancy::free);
  for (std::size_t i = 0; i < cost.values.size(); ++i) {
    if (cost.values[i] == ground::kLethal) occupancy.values[i] = Occupancy::occupied;
    if (cost.values[i] == ground::kUnknown) occupancy.values[i] = Occupancy::unknown;
  }
  return occupancy;
}

// Blocked cells of the truth, with 254 so that they are a costmap's too.
Grid<std::uint8_t> truth_of(const Grid<std::uint8_t>& cost, const std::vector<survey::Obstacle>& hidden) {
  auto occupancy = occupancy_of(cost);
  const auto marked = ground::mark_obstacles(hidden, occupancy);
  if (!marked.not_finite.empty())
    throw base::Error(base::ErrorCode::invalid_input, "a hidden obstacle has no finite place or width")
        .record("obstacle " + std::to_string(marked.not_finite.front()));
  Grid<std::uint8_t> truth(cost.geometry, 0);
  for (std::size_t i = 0; i < truth.values.size(); ++i)
    truth.values[i] = occupancy.values[i] == Occupancy::occupied ? ground::kLethal : std::uint8_t{0};
  return truth;
}

// Whether the centre of a blocked cell lies in the body, or half a cell beside it.
bool touches(const Grid<std::uint8_t>& truth, const Pose2& pose, double length, double width) {
  const auto& g = truth.geometry;
  const double half_length = 0.5 * (length + g.cell), half_width = 0.5 * (width + g.cell);
  const double reach = std::hypot(half_length, half_width);
  const Vec2 corner(reach, reach);
  const auto region = ground::cells_of(g, pose.position - corner, pose.position + corner);
  const Vec2 forward(std::cos(pose.yaw), std::sin(pose.yaw)), left(-forward.y(), forward.x());
  for (std::size_t r = region.row; r < region.end_row(); ++r)
    for (std::size_t c = region.column; c < region.end_column(); ++c) {
      if (truth.at(r, c) == 0) continue;
      const Vec2 offset = g.centre(r, c) - pose.position;
      if (std::abs(offset.dot(forward)) <= half_length && std::abs(offset.dot(left)) <= half_width) return true;
    }
  return false;
}

// First-order Gauss-Markov process.
class Drift {
 public:
  Drift(double sigma, double time_s, double dt)
      : keep_(std::exp(-dt / time_s)), kick_(sigma * std::sqrt(1.0 - keep_ * keep_)) {}
  // Starts at zero: vehicles know where they are put down.
  double next(base::Random& random) { return value_ = keep_ * value_ + kick_ * random.normal(); }

 private:
  double keep_, kick_, value_ = 0.0;
};

double first_heading(const std::vector<Vec2>& route) {
  constexpr double kAhead_m = 1.0;
  for (const auto& p : route)
    if ((p - route.front()).norm() >= kAhead_m || &p == &route.back()) {
      const Vec2 way = p - route.front();
      return std::atan2(way.y(), way.x());
    }
  return 0.0;
}

survey::VehicleState state_of(const Pose2& pose, const ground::DriveVelocity& velocity, std::int64_t time_ns) {
  survey::VehicleState state;
  state.time_ns = time_ns;
  state.position = pose.position;
  state.velocity = velocity.forward_m_s * Vec2(std::cos(pose.yaw), std::sin(pose.yaw));
  state.yaw = pose.yaw;
  return state;
}

}  // namespace

void RouteDriveOptions::visit(base::OptionVisitor& v) {
  driver.visit_driving(v);
  v.real("radius-m", cost.radius_m, 0.0, 100.0,
         "radius of the vehicle, for what is found on the way; as in the costmap");
  v.real("alpha", cost.alpha, 0.01, 100.0, "fall of the cost with distance, 1/m; as in the costmap");
  scanner.visit(v);
  v.real("body-length-m", body_length_m, 0.05, 20.0, "length of the vehicle, for collisions");
  v.real("body-width-m", body_width_m, 0.05, 20.0, "width of the vehicle, for collisions");
  v.real("pose-sigma-m", pose_sigma_m, 0.0, 10.0, "error of the vehicle's own position, one axis");
  v.real("pose-time-s", pose_time_s, 0.1, 1e6, "time over which that error drifts");
  v.real("heading-sigma-deg", heading_sigma_deg, 0.0, 90.0, "error of the vehicle's own heading");
  v.real("slip-sigma", slip_sigma, 0.0, 0.5, "share by which it turns more or less than told");
  v.real("time-limit-s", time_limit_s, 1.0, 1e6, "the drive is given up after this long");
}

RouteDrive drive_route(const Grid<std::uint8_t>& cost, const std::vector<Vec2>& route, const RouteDriveInputs& inputs,
                       const RouteDriveOptions& options, base::RunContext& ctx) {
  ground::LiveCostmapOptions live_options;
  live_options.cost = options.cost;
  live_options.cost.resolution_m = cost.geometry.cell;
  ground::LiveCostmap live(occupancy_of(cost), live_options);
  ground::ObstacleMap obstacles;
  ground::Driver driver(route.back(), options.driver);
  const Grid<std::uint8_t> truth = truth_of(cost, inputs.hidden);

  const double tick_s = 1.0 / options.driver.local.rate_hz;
  const auto tick_ns = static_cast<std::int64_t>(std::llround(tick_s * 1e9));
  const auto scan_ns = static_cast<std::int64_t>(std::llround(1e9 / options.scanner.rate_hz));
  std::int64_t start_ns = 0;
  for (std::size_t i = 0; i < inputs.packets.size(); ++i)
    start_ns = i == 0 ? inputs.packets[i].packet.capture_time_ns
                      : std::min(start_ns, inputs.packets[i].packet.capture_time_ns);
  base::Random noise = ctx.random("route drive", 0);
  const double turn_share = 1.0 + options.slip_sigma * noise.normal();
  Drift east(options.pose_sigma_m, options.pose_time_s, tick_s), north = east;
  Drift heading(options.heading_sigma_deg * kDegree, options.pose_time_s, tick_s);

  RouteDrive run;
  Pose2 pose{route.front(), first_heading(route)};
  ground::DriveVelocity velocity;
  std::size_t arrived = 0;
  std::int64_t next_scan_ns = start_ns;
  bool touching = false;
  double delay_sum = 0.0;
  const auto ticks = static_cast<std::int64_t>(options.time_limit_s / tick_s);
  for (std::int64_t i = 0; i <= ticks; ++i) {
    ctx.check_stop();
    const std::int64_t now_ns = start_ns + i * tick_ns;
    run.track.push_back(state_of(pose, velocity, now_ns));
    run.time_s = static_cast<double>(i) * tick_s;
    const Vec2 off(east.next(noise), north.next(noise));
    const Pose2 believed{pose.position + off, ground::wrapped(pose.yaw + heading.next(noise))};

    bool news = false;
    for (; arrived < inputs.packets.size() && inputs.packets[arrived].arrival_time_ns <= now_ns; ++arrived) {
      const auto& packet = inputs.packets[arrived];
      static_cast<void>(obstacles.add(packet.packet));
      const double delay = static_cast<double>(packet.arrival_time_ns - packet.packet.capture_time_ns) * 1e-9;
      delay_sum += delay;
      run.max_delay_s = std::max(run.max_delay_s, delay);
      ++run.packets;
      news = true;
    }
    if (news) live.set_obstacles(obstacles.obstacles(now_ns));
    if (now_ns >= next_scan_ns) {
      next_scan_ns += scan_ns;
      base::Random random = ctx.random("route drive scan", static_cast<std::uint64_t>(i));
      const auto scan = simulation::scan_grid(truth, pose, now_ns, options.scanner, random);
      live.add_scan(scan, [&](std::int64_t) { return believed; });
      ++run.scans;
    }
    live.update();
    const auto tick = driver.tick(now_ns, believed, velocity, live.cost(), ctx);
    run.status = tick.status;
    run.reason = tick.status == ground::DriveStatus::blocked ? tick.reason : "";
    if (tick.status == ground::DriveStatus::arrived) break;

    // The vehicle does what it was told, but turns a little more or less.
    velocity = tick.command;
    for (int k = 0; k < kMotionSteps; ++k) {
      const Vec2 from = pose.position;
      pose = ground::moved(pose, {velocity.forward_m_s, velocity.turn_rad_s * turn_share}, tick_s / kMotionSteps);
      run.length_m += (pose.position - from).norm();
      const bool touch = touches(truth, pose, options.body_length_m, options.body_width_m);
      if (touch && !touching) ++run.collisions;
      touching = touch;
    }
  }
  std::vector<Vec2> track;
  for (const auto& state : run.track) track.push_back(state.position);
  run.clearance_m = ground::clearance_m(truth, track, kFarthest_m);
  auto true_occupancy = occupancy_of(cost);
  for (std::size_t i = 0; i < truth.values.size(); ++i)
    if (truth.values[i] != 0) true_occupancy.values[i] = Occupancy::occupied;
  run.weighted_length_m =
      ground::weighted_length_m(ground::costmap(true_occupancy, live_options.cost), track, options.driver.route);
  run.mean_delay_s = run.packets == 0 ? 0.0 : delay_sum / static_cast<double>(run.packets);
  run.replans = driver.replans();
  run.plans = driver.plans();
  run.recoveries = driver.recoveries();
  run.expansions = driver.expansions();
  return run;
}

}  // namespace cairn::pipeline
