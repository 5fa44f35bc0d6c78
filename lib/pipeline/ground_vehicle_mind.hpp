// What a ground vehicle of a closed loop knows and decides: pose filter, obstacle list, costmap, driver.
#pragma once

#include <vector>

#include "ground/drive.hpp"
#include "ground/live_costmap.hpp"
#include "ground/obstacle_map.hpp"
#include "ground/pose_filter.hpp"
#include "pipeline/ground_run.hpp"

namespace cairn::pipeline {

class VehicleMind {
 public:
  VehicleMind(const simulation::DriveSpec& drive, const GroundRunOptions& options);

  void inertial(const survey::VehicleState& record);
  void receive(const survey::ReceivedPacket& received);
  // wheels: odometry, to know where the sensor is during the turn.
  void scan(const survey::RangeScan& scan, const ground::DriveVelocity& wheels);
  ground::DriveTick tick(std::int64_t now_ns, const ground::DriveVelocity& wheels, base::RunContext& ctx);

  [[nodiscard]] survey::VehicleState state() const { return filter_.state(); }
  [[nodiscard]] const geometry::Grid<std::uint8_t>& cost() const { return costmap_.cost(); }
  [[nodiscard]] const ground::Driver& driver() const { return driver_; }
  [[nodiscard]] std::vector<survey::Obstacle> obstacles() const { return map_.obstacles(now_ns_); }
  [[nodiscard]] const ground::SkidSteerOptions& limits() const { return driver_options_.vehicle; }
  [[nodiscard]] double rate_hz() const { return driver_options_.local.rate_hz; }

 private:
  static ground::DriverOptions driver_options(const simulation::DriveSpec& drive);
  static ground::LiveCostmapOptions costmap_options(const simulation::DriveSpec& drive,
                                                    const GroundRunOptions& options);

  bool aerial_map_, aerial_pose_;
  ground::PoseFilter filter_;
  ground::ObstacleMap map_;
  ground::LiveCostmap costmap_;
  ground::DriverOptions driver_options_;
  ground::Driver driver_;
  std::int64_t now_ns_ = 0;
  bool map_changed_ = false;
};

}  // namespace cairn::pipeline
