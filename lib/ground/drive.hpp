// Drives a vehicle to a goal: a global path (A*) and local velocities (DWA), paper B, B14.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "geometry/grid.hpp"
#include "geometry/vec.hpp"
#include "ground/dwa.hpp"
#include "ground/route.hpp"
#include "ground/skid_steer.hpp"

namespace cairn::ground {

struct DriverOptions {
  RouteOptions route;
  SkidSteerOptions vehicle;
  DwaOptions local;
  bool smooth = true;              // global paths are straightened before they are followed (ground/path.hpp)
  double goal_tolerance_m = 0.3;   // the goal is reached within this distance
  double replan_period_s = 5.0;    // a new path is looked for at least this often; 0 = only when needed
  double replan_interval_s = 1.0;  // and never more often than this
  double gain = 0.1;               // a new path is taken where what is left costs this share less than on the old one
  double rise = 0.1;  // a new path is looked for where what is left costs this share more than when it was planned
  double off_path_m = 1.0;  // ... or where the vehicle is this far beside it
  double snap_m = 0.6;      // where vehicle or goal stand on blocked ground, the nearest free cell within this serves
  double stuck_s = 4.0;     // without progress for this long: a recovery
  double recovery_s = 1.5;  // a recovery's length: turns towards the path, then backs off, in turns

  void visit(base::OptionVisitor& v);
  // All but the route's, for options that hold those already.
  void visit_driving(base::OptionVisitor& v);
};

enum class DriveStatus { driving, recovering, blocked, arrived };
[[nodiscard]] std::string_view name_of(DriveStatus status);

struct DriveTick {
  DriveStatus status = DriveStatus::driving;
  DriveVelocity command;   // within the vehicle's limits and accelerations
  bool replanned = false;  // a new global path was taken
  std::string reason;      // of a replan: first, blocked, off_path, costlier, cheaper, stuck;
                           // where blocked: start_blocked, goal_blocked, no_path, start_outside, goal_outside
};

// One vehicle on its way to one goal. Deterministic: the same ticks give the same commands.
class Driver {
 public:
  // goal: local ENU east and north, m. Throws invalid_argument for bad options.
  Driver(const geometry::Vec2& goal, const DriverOptions& options);

  // To be called at options.local.rate_hz. pose: where the vehicle believes to be (filtered); velocity: what it does
  // now. cost: the whole costmap of what is known by now, values of ground/costmap.hpp; it may change, and even be
  // another grid, from tick to tick. Cost of a tick: the local window, the path's cells, and now and then one
  // find_route.
  DriveTick tick(std::int64_t now_ns, const PlanarPose& pose, const DriveVelocity& velocity,
                 const geometry::Grid<std::uint8_t>& cost, base::RunContext& ctx);

  // The global path that is followed, all of it, local ENU, m; empty where there is none.
  [[nodiscard]] const std::vector<geometry::Vec2>& path() const { return path_; }
  [[nodiscard]] const geometry::Vec2& goal() const { return goal_; }
  [[nodiscard]] std::size_t replans() const { return replans_; }  // paths taken after the first
  [[nodiscard]] std::size_t plans() const { return plans_; }      // searches, the first included
  [[nodiscard]] std::size_t recoveries() const { return recoveries_; }
  [[nodiscard]] std::uint64_t expansions() const { return expansions_; }  // of all searches

 private:
  struct Ahead {
    double weighted_m = 0.0;  // what is left of the path costs
    bool blocked = false;
  };
  [[nodiscard]] Ahead ahead(const geometry::Grid<std::uint8_t>& cost) const;
  // Why a new path is needed now; empty = it is not.
  [[nodiscard]] std::string need(std::int64_t now_ns, const PlanarPose& pose, const Ahead& left) const;
  void plan(std::int64_t now_ns, const PlanarPose& pose, const geometry::Grid<std::uint8_t>& cost, const Ahead& left,
            const std::string& need, DriveTick& tick, base::RunContext& ctx);
  void follow(const PlanarPose& pose);
  [[nodiscard]] bool stuck(std::int64_t now_ns, const PlanarPose& pose);
  [[nodiscard]] DriveVelocity recover(const PlanarPose& pose, const DriveVelocity& velocity,
                                      const geometry::Grid<std::uint8_t>& cost) const;

  geometry::Vec2 goal_;
  DriverOptions options_;
  std::vector<geometry::Vec2> path_;
  std::size_t at_ = 0;         // index of the path's point nearest the vehicle
  std::vector<double> to_go_;  // weighted way left from each point of the path when it was planned, m
  std::string no_path_;        // reason of the last search where it found none
  std::optional<std::int64_t> planned_ns_;
  std::optional<std::int64_t> recovery_ns_;  // start of the recovery under way
  std::int64_t progress_ns_ = 0;
  std::optional<PlanarPose> progress_;  // pose at the last progress
  bool arrived_ = false, had_path_ = false;
  std::size_t replans_ = 0, plans_ = 0, recoveries_ = 0;
  std::uint64_t expansions_ = 0;
};

}  // namespace cairn::ground
