#include "pipeline/plan_mission.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/kml.hpp"
#include "io/layer_csv.hpp"
#include "io/mission_json.hpp"
#include "io/mission_layers.hpp"
#include "io/qgc_plan.hpp"
#include "io/survey_folder.hpp"
#include "planning/camera_aim.hpp"
#include "planning/minimum_snap.hpp"

namespace cairn::pipeline {
namespace {

using geometry::Vec3;
using survey::Waypoint;

constexpr double kNanoseconds = 1e9;
constexpr double kRest_s = 1.0;      // at a stop with an image, as mission.plan has it
constexpr double kSettled_m = 0.05;  // of a clearance: what a smooth curve may cut off a corner

}  // namespace

void connect_safely(std::vector<Waypoint>& waypoints, std::vector<std::size_t>& view_waypoint,
                    const planning::SurfaceHeights& surface, const planning::ClearanceOptions& clearance) {
  std::vector<Waypoint> connected;
  std::vector<std::size_t> place(waypoints.size());
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    const Waypoint& to = waypoints[i];
    if (i > 0 && waypoints[i - 1].stop && to.stop) {
      const Waypoint& from = waypoints[i - 1];
      // Along a lane the height was chosen already.
      const bool leg = !(from.role == survey::WaypointRole::lane && from.trigger_m > 0.0);
      if (leg)
        for (const Vec3& p : planning::safe_leg(from.position, to.position, surface, clearance)) {
          Waypoint via;
          via.position = p;
          via.heading_deg = to.heading_deg;
          via.pitch_deg = to.pitch_deg;
          via.stop = true;
          via.role = survey::WaypointRole::transit;
          via.group = to.group;
          connected.push_back(via);
        }
    }
    place[i] = connected.size();
    connected.push_back(to);
  }
  for (std::size_t& w : view_waypoint) w = place[w];
  waypoints = std::move(connected);
}

void fly(survey::Mission& mission, const std::vector<std::size_t>& view_waypoint,
         const planning::TrajectoryOptions& options) {
  mission.limits = {options.max_speed_m_s, options.max_acceleration_m_s2, options.max_yaw_rate_deg_s};
  std::vector<planning::FlightKey> keys;
  for (const Waypoint& w : mission.waypoints) {
    planning::FlightKey key;
    key.pose << w.position, planning::yaw_of_heading(w.heading_deg);
    key.stop = w.stop;
    keys.push_back(key);
  }
  planning::Flight flight = planning::plan_flight(keys, options);
  for (std::size_t i = 0; i < keys.size(); ++i) mission.waypoints[i].time_s = flight.key_times_s[i];
  mission.trajectory = std::move(flight.trajectory);

  for (std::size_t v = 0; v < mission.views.size(); ++v) {
    survey::Frame& view = mission.views[v];
    const std::size_t w = view_waypoint[v];
    const Vec3 from = mission.waypoints[w].position;
    const double wanted = (view.T_world_camera.translation - from).norm();
    double early = mission.waypoints[w].time_s;
    double late = w + 1 < mission.waypoints.size() ? mission.waypoints[w + 1].time_s : early;
    // The distance from the waypoint grows along the stretch.
    for (int i = 0; i < 60 && wanted > 0.0; ++i) {
      const double middle = 0.5 * (early + late);
      const Vec3 p = planning::evaluate(mission.trajectory, middle).head<3>();
      ((p - from).norm() < wanted ? early : late) = middle;
    }
    view.time_ns = static_cast<std::int64_t>(std::llround(early * kNanoseconds));
    view.T_world_camera = io::exact_pose(view.T_world_camera);
  }
}

double mission_time(const survey::Mission& mission) {
  const auto rests = std::count_if(mission.waypoints.begin(), mission.waypoints.end(),
                                   [](const Waypoint& w) { return w.photo && w.stop; });
  return planning::duration(mission.trajectory) + kRest_s * static_cast<double>(rests);
}

MissionChecks check_mission(survey::Mission& mission, const planning::SurfaceHeights& surface,
                            const planning::ClearanceOptions& clearance, base::RunContext& ctx) {
  MissionChecks checks;
  checks.peaks = planning::peaks(mission.trajectory);
  checks.duration_s = mission_time(mission);
  for (std::size_t i = 1; i < mission.waypoints.size(); ++i)
    checks.length_m += (mission.waypoints[i].position - mission.waypoints[i - 1].position).norm();
  checks.clearance = planning::least_clearance(mission.trajectory, surface, clearance.clearance_radius_m);
  const auto where = [&] {
    const Vec3& p = checks.clearance.at;
    return base::to_fixed(checks.clearance.height_m, 2) + " m at east " + base::to_fixed(p.x(), 1) + ", north " +
           base::to_fixed(p.y(), 1) + ", up " + base::to_fixed(p.z(), 1) + " m";
  };
  if (checks.clearance.height_m < 0.0)
    throw base::Error(base::ErrorCode::failed_precondition, "the mission would fly below the surface")
        .found(where())
        .allowed(base::to_text(clearance.clearance_m) + " m or more above it")
        .hint("Plan with this terrain, a larger --stand-off-m or another height");
  if (checks.clearance.height_m < clearance.clearance_m - kSettled_m) {
    mission.notes.push_back("comes to within " + where() + " of the surface, closer than --clearance-m");
    ctx.warn("The mission " + mission.notes.back());
  }
  if (checks.clearance.unknown > 0) {
    mission.notes.push_back("the surface is not known below " + std::to_string(checks.clearance.unknown) + " of " +
                            std::to_string(checks.clearance.samples) + " samples of the path");
    ctx.warn("The clearance is not proved everywhere: " + mission.notes.back());
  }
  return checks;
}

void write_mission_files(const std::filesystem::path& out, const survey::Mission& mission,
                         std::optional<double> home_up_m) {
  io::write_mission(out / "mission.json", mission);
  io::write_qgc_plan(out / "mission.plan", mission, home_up_m);
  io::write_layer_csv(out / "mission.csv", io::waypoint_layer(mission));
  base::write_file(out / "mission.geojson", io::mission_geojson(mission));
  io::write_kml(out / "mission.kml", {io::path_layer(mission), io::waypoint_layer(mission), io::view_layer(mission)},
                "DRAFT " + mission.name);
}

io::Json mission_summary(const survey::Mission& mission, const MissionChecks& checks) {
  const auto& c = checks.clearance;
  return io::Json::object({{"status", "DRAFT"},
                           {"kind", survey::name_of(mission.kind)},
                           {"waypoints", mission.waypoints.size()},
                           {"images", mission.views.size()},
                           {"length_m", checks.length_m},
                           {"duration_s", checks.duration_s},
                           {"peak_speed_m_s", checks.peaks.speed_m_s},
                           {"peak_acceleration_m_s2", checks.peaks.acceleration_m_s2},
                           {"peak_yaw_rate_deg_s", checks.peaks.yaw_rate_deg_s},
                           {"least_clearance_m", c.unknown < c.samples ? io::Json(c.height_m) : io::Json()},
                           {"clearance_unknown_fraction",
                            c.samples > 0 ? static_cast<double>(c.unknown) / static_cast<double>(c.samples) : 0.0}});
}

}  // namespace cairn::pipeline
