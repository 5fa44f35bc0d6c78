#include "pipeline/drive_stage.hpp"

#include <algorithm>
#include <cstdio>
#include <vector>

#include "base/atomic_file.hpp"
#include "base/number_text.hpp"
#include "geodesy/local_frame.hpp"
#include "io/csv.hpp"
#include "io/packets.hpp"
#include "io/range_scans.hpp"
#include "io/ros_map.hpp"
#include "io/survey_folder.hpp"
#include "io/truth.hpp"
#include "io/vehicle_csv.hpp"
#include "pipeline/ground_figures.hpp"
#include "report/drive_figure.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using geometry::Vec2;

constexpr double kSetPeriod_s = 0.25;  // B3: the projector's rate
constexpr std::uint8_t kOccupied100 = 100;

void write_prior(const fs::path& out, const survey::Origin& origin, const simulation::DriveSpec& drive,
                 double resolution_m) {
  const auto prior = prior_map(drive, resolution_m);
  io::RosMap map;
  map.occupancy = geometry::Grid<std::uint8_t>(prior.geometry, 0);
  for (std::size_t i = 0; i < prior.values.size(); ++i)
    map.occupancy.values[i] = prior.values[i] == ground::Occupancy::occupied ? kOccupied100 : std::uint8_t{0};
  fs::create_directories(out / "prior");
  io::write_ros_map(out / "prior", "map", map,
                    io::MapGeoreference{origin.position, origin.height_type, origin.geoid,
                                        geodesy::LocalFrame(origin.position).raster_crs_wkt()});
}

void write_plans(const fs::path& path, const GroundRecord& record) {
  io::CsvWriter csv(path, {"plan", "time_ns", "reason", "order", "x_m", "y_m"});
  std::int64_t number = 0;
  for (const GroundPlan& plan : record.plans) {
    ++number;
    const auto corners = ground::without_collinear(plan.path);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      csv.cell(number).cell(plan.time_ns).cell(plan.reason).cell(static_cast<std::int64_t>(i + 1));
      csv.cell(corners[i].x()).cell(corners[i].y());
      csv.end_row();
    }
  }
  csv.finish();
}

void write_figures(const fs::path& folder, const simulation::DriveRehearsal& rehearsal, const GroundRecord& record,
                   const std::string& name) {
  base::write_file(folder / "paths.svg", drive_svg(rehearsal, record, record.snapshots.size(), name));
  for (std::size_t i = 0; i < record.snapshots.size(); ++i) {
    const auto& snapshot = record.snapshots[i];
    const std::string when = base::to_fixed(1e-9 * static_cast<double>(snapshot.time_ns), 1) + " s";
    char file[64];
    std::snprintf(file, sizeof(file), "costmap_%zu.svg", i + 1);
    base::write_file(folder / file, drive_svg(rehearsal, record, i, name + ", " + snapshot.label + ", at " + when));
  }
  std::vector<double> times, periods;
  for (std::size_t i = 1; i < record.packets.size(); ++i) {
    times.push_back(1e-9 * static_cast<double>(record.packets[i].arrival_time_ns));
    periods.push_back(times.back() - 1e-9 * static_cast<double>(record.packets[i - 1].arrival_time_ns));
  }
  if (!times.empty())
    base::write_file(folder / "update_periods.svg", report::update_periods_svg(name, times, periods, kSetPeriod_s));
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

io::Json pair_json(const Vec2& p) {
  return io::Json(std::vector<double>{p.x(), p.y()});
}

}  // namespace

io::Json drive_json(const GroundRecord& record) {
  io::Json contacts = io::Json::array(), plans = io::Json::array();
  for (const auto& contact : record.contacts)
    contacts.push(io::Json::object(
        {{"time_ns", contact.time_ns}, {"class", contact.object}, {"position_m", pair_json(contact.position)}}));
  for (const auto& plan : record.plans) {
    double length = 0.0;
    for (std::size_t i = 1; i < plan.path.size(); ++i) length += (plan.path[i] - plan.path[i - 1]).norm();
    plans.push(io::Json::object({{"time_ns", plan.time_ns}, {"reason", plan.reason}, {"length_m", length}}));
  }
  const auto& periods = record.update_periods_s;
  return io::Json::object(
      {{"arrived", record.arrived},
       {"status", record.status},
       {"path_m", record.path_m},
       {"drive_s", record.drive_s},
       {"contacts", static_cast<std::int64_t>(record.contacts.size())},
       {"least_clearance_m", record.least_clearance_m},
       {"goal_error_m", record.goal_error_m},
       {"replans", static_cast<std::int64_t>(record.plans.empty() ? 0 : record.plans.size() - 1)},
       {"recoveries", record.recoveries},
       {"pose_rms_m", record.pose_rms_m},
       {"pose_max_m", record.pose_max_m},
       {"inertial_rms_m", record.inertial_rms_m},
       {"packets", record.packets.size()},
       {"update_period_mean_s", mean(periods)},
       {"update_period_max_s", periods.empty() ? 0.0 : *std::max_element(periods.begin(), periods.end())},
       {"obstacles", record.obstacles.size()},
       {"touched", std::move(contacts)},
       {"plans", std::move(plans)}});
}

Outcome drive_stage(const simulation::Scene& scene, const fs::path& out, const GroundRunOptions& options,
                    base::RunContext& ctx) {
  const simulation::DriveRehearsal rehearsal(scene, ctx);
  GroundRecord record = run_ground(rehearsal, options, ctx.seed, ctx);
  const auto base = record.aerial.survey.manifest.time_base;
  auto& manifest = record.aerial.survey.manifest;
  io::write_truth(record.aerial.truth, manifest.origin, out);
  io::write_survey(record.aerial.survey, out);
  io::write_vehicle_csv(out / "vehicle.csv", record.inertial);
  io::write_vehicle_csv(out / "truth" / "vehicle.csv", record.truth);
  io::write_range_scans(out / "lidar.csv", record.scans);
  io::write_packets(out / "packets.bin", record.packets, base);
  write_prior(out, manifest.origin, *scene.drive, options.map_resolution_m);
  fs::create_directories(out / "drive");
  io::write_vehicle_csv(out / "drive" / "vehicle.csv", record.filtered);
  write_plans(out / "drive" / "plans.csv", record);
  write_figures(out / "drive", rehearsal, record, scene.name);

  io::Json file = io::Json::object({{"scene", scene.name},
                                    {"seed", static_cast<std::int64_t>(ctx.seed)},
                                    {"aerial_map", options.aerial_map},
                                    {"aerial_pose", options.aerial_pose},
                                    {"outage_s", options.outage_s}});
  io::Json summary = io::Json::object({{"scene", scene.name},
                                       {"frames", record.aerial.survey.frames.size()},
                                       {"detections", record.aerial.survey.detections.size()},
                                       {"objects", record.aerial.truth.objects.size()},
                                       {"scans", record.scans.size()}});
  const io::Json result = drive_json(record);
  for (const auto& [key, value] : result.as_object()) {
    file.set(key, value);
    if (key != "touched" && key != "plans") summary.set(key, value);
  }
  base::write_file(out / "drive" / "drive.json", file.dump() + "\n");
  return {std::move(summary), {}};
}

}  // namespace cairn::pipeline
