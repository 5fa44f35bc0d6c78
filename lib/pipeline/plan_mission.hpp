// From waypoints to a complete mission: safe legs, trajectory, checks, files.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/run_context.hpp"
#include "io/json.hpp"
#include "planning/clearance.hpp"
#include "planning/surface_heights.hpp"
#include "planning/trajectory.hpp"
#include "survey/mission.hpp"

namespace cairn::pipeline {

// Puts waypoints between those that are stops on both sides of a leg, where the straight line would come too close to
// the surface: up, across, down. view_waypoint (indices of waypoints) is kept up to date.
void connect_safely(std::vector<survey::Waypoint>& waypoints, std::vector<std::size_t>& view_waypoint,
                    const planning::SurfaceHeights& surface, const planning::ClearanceOptions& clearance);

// Trajectory through the waypoints, times of waypoints and views (time_ns from the start), limits.
// view_waypoint: for each view the waypoint after which (or at which) it is taken.
void fly(survey::Mission& mission, const std::vector<std::size_t>& view_waypoint,
         const planning::TrajectoryOptions& options);

// Duration of the trajectory and 1 s at rest at each stop with an image, s.
[[nodiscard]] double mission_time(const survey::Mission& mission);

struct MissionChecks {
  planning::Peaks peaks;
  planning::LeastClearance clearance;
  double length_m = 0.0, duration_s = 0.0;  // mission_time()
};

// Peaks, length, and the least height above the surface along the whole trajectory. Throws failed_precondition where
// it goes below the surface; warns, and notes it in the mission, where it comes closer than the clearance.
MissionChecks check_mission(survey::Mission& mission, const planning::SurfaceHeights& surface,
                            const planning::ClearanceOptions& clearance, base::RunContext& ctx);

// mission.json, .plan, .kml, .geojson and .csv. home_up_m: local up of the launch point, where it is known.
void write_mission_files(const std::filesystem::path& out, const survey::Mission& mission,
                         std::optional<double> home_up_m);

// Figures every kind of mission has.
[[nodiscard]] io::Json mission_summary(const survey::Mission& mission, const MissionChecks& checks);

}  // namespace cairn::pipeline
