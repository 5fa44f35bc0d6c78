// Paper B's system in closed loop: an aircraft that maps and a ground vehicle (UGV) that drives, in a simulated scene.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "geometry/grid.hpp"
#include "ground/drive.hpp"
#include "ground/frame_packet.hpp"
#include "ground/live_costmap.hpp"
#include "ground/obstacle_map.hpp"
#include "ground/pose_filter.hpp"
#include "simulation/drive_rehearsal.hpp"
#include "survey/ground_vehicle.hpp"
#include "survey/packet.hpp"
#include "survey/range_scan.hpp"

namespace cairn::pipeline {

struct GroundRunOptions {
  bool aerial_map = true;   // the vehicle takes obstacles from the packets into its map
  bool aerial_pose = true;  // ... and its own positions into its pose filter
  // Outages of the link, once in each outage_period_s, the first at a time that the seed draws.
  double outage_s = 0.0;  // length of each; 0 = none
  double outage_period_s = 30.0;
  // Every time that the vehicle's wheels slip: sigma of the share of speed and turn that is lost or won, changing over
  // about a second.
  double slip_share = 0.03;
  double map_resolution_m = 0.05;  // B13
  double radius_m = 0.35;          // R of (B.9)
  std::string mode = "robust";     // of projector, obstacle memory and pose filter: paper or robust

  void visit(base::OptionVisitor& v);
};

struct GroundPlan {
  std::int64_t time_ns = 0;
  std::string reason;
  std::vector<geometry::Vec2> path;  // local ENU, m
};

struct GroundContact {
  std::int64_t time_ns = 0;
  std::string object;  // class of what was touched
  geometry::Vec2 position = geometry::Vec2::Zero();
};

// The costmap as the vehicle had it.
struct GroundSnapshot {
  std::int64_t time_ns = 0;
  std::string label;  // "start", "goal"
  geometry::Grid<std::uint8_t> cost;
};

struct GroundRecord {
  simulation::Recording aerial;  // frames, detections and truth up to the end; the vehicle is its last object
  std::vector<survey::VehicleState> truth, inertial, filtered;  // 50 Hz; truth at the same times
  std::vector<survey::RangeScan> scans;
  std::vector<survey::ReceivedPacket> packets;  // in order of arrival; empty where the vehicle does not listen
  std::vector<survey::Obstacle> obstacles;      // the vehicle's list at the end
  std::vector<GroundPlan> plans;
  std::vector<GroundContact> contacts;
  std::vector<GroundSnapshot> snapshots;
  bool arrived = false;
  std::string status;                         // at the end: arrived, driving, recovering, blocked
  double start_s = 0.0;                       // clock time at which the vehicle was allowed to go
  double drive_s = 0.0;                       // from then to the end
  double path_m = 0.0;                        // true way driven
  double least_clearance_m = 0.0;             // true, body to the nearest object
  double goal_error_m = 0.0;                  // true position at the end to the goal
  double pose_rms_m = 0.0, pose_max_m = 0.0;  // filtered less true position, while driving
  double inertial_rms_m = 0.0;                // inertial alone less true position, while driving
  std::size_t recoveries = 0;
  std::vector<double> update_periods_s;  // between arrivals, from start_s on
};

// The vehicle's known ground before it drives: free inside the scene's area, occupied outside it and in what the prior
// map holds as blocked.
[[nodiscard]] ground::OccupancyGrid prior_map(const simulation::DriveSpec& drive, double resolution_m);

// One run. The seed draws all errors. Time on all records: the vehicle's clock (base boot), the first frame at
// simulation::kFirstFrame_s. Deterministic.
[[nodiscard]] GroundRecord run_ground(const simulation::DriveRehearsal& rehearsal, const GroundRunOptions& options,
                                      std::uint64_t seed, base::RunContext& ctx);

}  // namespace cairn::pipeline
