// A route driven in simulation: a costmap as it was known, obstacles that nobody knew, scans, and late packets.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "geometry/grid.hpp"
#include "geometry/vec.hpp"
#include "ground/costmap.hpp"
#include "ground/drive.hpp"
#include "simulation/grid_scanner.hpp"
#include "survey/ground_vehicle.hpp"
#include "survey/obstacle.hpp"
#include "survey/packet.hpp"

namespace cairn::pipeline {

struct RouteDriveOptions {
  ground::DriverOptions driver;  // its route options are those of the route
  ground::CostmapOptions cost;   // inflation of what is found on the way; as the costmap was made
  simulation::GridScannerOptions scanner;
  double body_length_m = 0.508, body_width_m = 0.43;  // a Clearpath Jackal: what may touch nothing
  double pose_sigma_m = 0.1;  // 1 sigma of an axis of the vehicle's own position, drifting with pose_time_s
  double pose_time_s = 20.0;
  double heading_sigma_deg = 1.0;  // the same of its heading
  double slip_sigma = 0.05;        // 1 sigma of the share by which the vehicle turns more or less than told, one a run
  double time_limit_s = 1800.0;

  void visit(base::OptionVisitor& v);
};

// What is and what comes, beside the costmap.
struct RouteDriveInputs {
  std::vector<survey::Obstacle> hidden;         // stand there, but not in the costmap
  std::vector<survey::ReceivedPacket> packets;  // by arrival time; the drive starts at the first capture time
};

struct RouteDrive {
  ground::DriveStatus status = ground::DriveStatus::driving;  // driving: the time was up
  std::string reason;                                         // where blocked
  std::vector<survey::VehicleState> track;                    // the true motion, every tick
  double length_m = 0.0, time_s = 0.0;
  double clearance_m = 0.0;  // least distance of the vehicle's centre to the centre of a cell that is blocked in truth
  double weighted_length_m = 0.0;  // of the track, over the true costmap
  std::size_t collisions = 0;      // times the body came over a blocked cell
  std::size_t replans = 0, plans = 0, recoveries = 0, scans = 0, packets = 0;
  double mean_delay_s = 0.0, max_delay_s = 0.0;  // of the packets that arrived during the drive
  std::uint64_t expansions = 0;
};

// Drives from `start` (heading along the first metre of the route) to `goal`. What the vehicle knows at first is
// `cost`: its obstacle and unknown cells; scans and packets add to it (ground/live_costmap.hpp,
// ground/obstacle_map.hpp). True are the obstacle cells of `cost` and the hidden obstacles; unknown ground is free. The
// scans are taken where the vehicle is, and drawn where it believes to be. Deterministic by ctx.seed.
RouteDrive drive_route(const geometry::Grid<std::uint8_t>& cost, const std::vector<geometry::Vec2>& route,
                       const RouteDriveInputs& inputs, const RouteDriveOptions& options, base::RunContext& ctx);

}  // namespace cairn::pipeline
