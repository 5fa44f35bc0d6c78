#include "pipeline/ground_vehicle_mind.hpp"

#include <algorithm>

#include "geometry/pose2.hpp"

namespace cairn::pipeline {

using geometry::Vec2;

ground::OccupancyGrid prior_map(const simulation::DriveSpec& drive, double resolution_m) {
  Vec2 lo = drive.area.front(), hi = lo;
  for (const Vec2& p : drive.area) {
    lo = lo.cwiseMin(p);
    hi = hi.cwiseMax(p);
  }
  ground::OccupancyGrid grid(geometry::covering_grid(lo, hi, resolution_m), ground::Occupancy::occupied);
  static_cast<void>(ground::mark_polygon({{drive.area}}, ground::Occupancy::free, grid));
  for (const auto& ring : drive.prior_blocked)
    static_cast<void>(ground::mark_polygon({{ring}}, ground::Occupancy::occupied, grid));
  return grid;
}

ground::DriverOptions VehicleMind::driver_options(const simulation::DriveSpec& drive) {
  ground::DriverOptions options;
  options.goal_tolerance_m = drive.goal_tolerance_m;
  return options;
}

ground::LiveCostmapOptions VehicleMind::costmap_options(const simulation::DriveSpec& drive,
                                                        const GroundRunOptions& options) {
  ground::LiveCostmapOptions result;
  result.cost.resolution_m = options.map_resolution_m;
  result.cost.radius_m = options.radius_m;
  result.scans.obstacle_range_m = std::min(result.scans.obstacle_range_m, drive.scanner.range_max_m);
  return result;
}

VehicleMind::VehicleMind(const simulation::DriveSpec& drive, const GroundRunOptions& options)
    : aerial_map_(options.aerial_map),
      aerial_pose_(options.aerial_pose),
      filter_([&] {
        ground::PoseFilterOptions filter;
        filter.mode = options.mode;
        return filter;
      }()),
      map_([&] {
        ground::ObstacleMapOptions map;
        map.memory = options.mode;
        return map;
      }()),
      costmap_(prior_map(drive, options.map_resolution_m), costmap_options(drive, options)),
      driver_options_(driver_options(drive)),
      driver_(drive.goal, driver_options_) {}

void VehicleMind::inertial(const survey::VehicleState& record) {
  now_ns_ = record.time_ns;
  filter_.inertial(record);
}

void VehicleMind::receive(const survey::ReceivedPacket& received) {
  if (aerial_pose_) filter_.packet(received);
  if (!aerial_map_) return;
  map_.add(received.packet);
  map_changed_ = true;
}

void VehicleMind::scan(const survey::RangeScan& scan, const ground::DriveVelocity& wheels) {
  const survey::VehicleState at = filter_.state();
  costmap_.add_scan(scan, [&](std::int64_t time_ns) -> std::optional<geometry::Pose2> {
    const double dt = 1e-9 * static_cast<double>(time_ns - at.time_ns);
    return geometry::Pose2{at.position + dt * at.velocity, at.yaw + dt * wheels.turn_rad_s};
  });
}

ground::DriveTick VehicleMind::tick(std::int64_t now_ns, const ground::DriveVelocity& wheels, base::RunContext& ctx) {
  if (map_changed_) {
    costmap_.set_obstacles(map_.obstacles(now_ns));
    map_changed_ = false;
  }
  static_cast<void>(costmap_.update());
  const survey::VehicleState at = filter_.state();
  return driver_.tick(now_ns, {at.position, at.yaw}, wheels, costmap_.cost(), ctx);
}

}  // namespace cairn::pipeline
