#include "pipeline/plan_stage.hpp"

#include <optional>
#include <utility>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "geodesy/local_frame.hpp"
#include "io/survey_folder.hpp"
#include "io/survey_json.hpp"
#include "io/targets_json.hpp"
#include "pipeline/plan_gaps.hpp"
#include "pipeline/plan_mission.hpp"
#include "planning/camera_aim.hpp"
#include "planning/view_selection.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Vec3;
using survey::HeightType;

struct Site {
  survey::Origin origin;
  survey::Camera camera;
  bool camera_given = false;
};

void require(const fs::path& path, const char* what, const char* option) {
  if (path.empty())
    throw Error(ErrorCode::invalid_argument, std::string(what) + " is needed").hint(std::string("Give ") + option);
}

// Origin and camera of the survey where there is one.
std::optional<Site> site_of_survey(const fs::path& survey_folder) {
  if (survey_folder.empty()) return std::nullopt;
  const survey::Survey survey = io::read_survey(survey_folder);
  if (survey.manifest.cameras.empty())
    throw Error(ErrorCode::invalid_input, "the survey has no camera").file(survey_folder.string());
  return Site{survey.manifest.origin, survey.manifest.cameras.front(), true};
}

HeightType declared(const PlanStageOptions& options, bool terrain) {
  if (options.height_type != "auto") return *survey::height_type_from(options.height_type);
  // Without a terrain the ground is the plane at 0: heights are those above the launch point.
  return terrain ? HeightType::unknown : HeightType::relative_takeoff;
}

void note_camera(survey::Mission& mission, const Site& site, base::RunContext& ctx) {
  mission.camera = site.camera;
  if (site.camera_given) return;
  const auto& c = site.camera;
  mission.notes.push_back("camera assumed: " + std::to_string(c.width_px) + " x " + std::to_string(c.height_px) +
                          " px, focal length " + base::to_text(c.fx_px) + " px");
  ctx.warn("The " + mission.notes.back());
}

std::optional<double> home_of(const PlanStageOptions& options, const survey::Mission& mission,
                              const planning::SurfaceHeights& surface) {
  if (options.home_up_m > PlanStageOptions::kNoHome) return options.home_up_m;
  return surface.up(mission.waypoints.front().position.head<2>());
}

Outcome finish(survey::Mission& mission, const std::vector<std::size_t>& view_waypoint, const fs::path& out,
               const planning::SurfaceHeights& surface, const PlanStageOptions& options, base::RunContext& ctx) {
  fly(mission, view_waypoint, options.trajectory);
  const MissionChecks checks = check_mission(mission, surface, options.clearance, ctx);
  const auto home = home_of(options, mission, surface);
  if (mission.origin.height_type == HeightType::unknown && home)
    mission.notes.push_back("heights of unknown datum: those of mission.plan are above a launch point at local up " +
                            base::to_fixed(*home, 2) + " m");
  Outcome outcome{mission_summary(mission, checks), {}};
  if (options.budget_s > 0.0) {
    outcome.summary.set("budget_s", options.budget_s);
    const bool within = checks.duration_s <= options.budget_s;
    outcome.summary.set("within_budget", within);
    if (!within) {
      mission.notes.push_back("takes " + base::to_fixed(checks.duration_s, 0) + " s, longer than the budget of " +
                              base::to_fixed(options.budget_s, 0) + " s");
      ctx.warn("The mission " + mission.notes.back());
    }
  }
  write_mission_files(out, mission, home);
  return outcome;
}

Outcome plan_area(const PlanInputs& in, const fs::path& out, const PlanStageOptions& options, base::RunContext& ctx) {
  require(in.area, "an area", "--area");
  const GeographicArea area = read_area(in.area);
  auto site = site_of_survey(in.survey);
  if (!site)
    site = Site{{area.centre(), declared(options, !in.terrain.empty()), ""}, plan_camera(options.camera), false};
  if (site->origin.height_type == HeightType::orthometric && site->origin.geoid.empty()) site->origin.geoid = "egm96";
  const geodesy::LocalFrame frame(site->origin.position);
  const auto surface = read_surface_heights(in.terrain, frame, options.surface_cell_m, ctx);
  planning::LawnmowerOptions lawnmower = options.lawnmower;
  lawnmower.clearance_m = options.clearance.clearance_m;
  lawnmower.clearance_radius_m = options.clearance.clearance_radius_m;
  planning::LawnmowerPlan plan;
  try {
    plan = planning::plan_lawnmower(area.in(frame), site->camera, surface, lawnmower, ctx);
  } catch (Error& error) {
    error.default_file(in.area.string());
    throw;
  }

  survey::Mission mission;
  mission.name = options.name;
  mission.kind = survey::MissionKind::lawnmower;
  mission.origin = site->origin;
  note_camera(mission, *site, ctx);
  for (const auto& note : plan.notes) mission.notes.push_back(note);
  if (in.terrain.empty()) mission.notes.emplace_back("no terrain given: the ground is taken as level at local up 0");
  mission.waypoints = std::move(plan.waypoints);
  mission.views = std::move(plan.views);
  connect_safely(mission.waypoints, plan.view_waypoint, surface, options.clearance);
  Outcome outcome = finish(mission, plan.view_waypoint, out, surface, options, ctx);
  io::Json& s = outcome.summary;
  s.set("lanes", plan.lanes);
  s.set("height_m", plan.height_m);
  s.set("image_spacing_m", plan.image_spacing_m);
  s.set("lane_spacing_m", plan.lane_spacing_m);
  s.set("footprint_along_m", plan.footprint_along_m);
  s.set("footprint_across_m", plan.footprint_across_m);
  s.set("wanted_views", plan.wanted_views);
  s.set("overlap", io::Json::object({{"points", plan.overlap.points},
                                     {"unknown", plan.overlap.unknown},
                                     {"uncovered", plan.overlap.uncovered},
                                     {"least_views", plan.overlap.least},
                                     {"first_percentile_views", plan.overlap.first_percentile},
                                     {"median_views", plan.overlap.median}}));
  s.set("coarsest_gsd_m", plan.overlap.coarsest_gsd_m);
  return outcome;
}

// Circles about each target that can be flown, nearest first.
struct CirclePlan {
  std::vector<survey::Waypoint> waypoints;
  std::vector<survey::Frame> views;
  std::vector<std::size_t> view_waypoint;
  io::Json rows = io::Json::array();
  std::vector<base::Reject> rejects;
  double least_side = 1.0, least_top = 1.0;
};

struct Cylinder {
  survey::TargetId id;
  geometry::VerticalCylinder shape;
};

std::vector<Cylinder> cylinders_of(const io::TargetsFile& file, const std::string& classes,
                                   std::vector<base::Reject>& rejects) {
  std::vector<Cylinder> cylinders;
  for (const survey::Target& target : file.targets) {
    if (target.state == survey::TargetState::deregistered) continue;
    if (!classes.empty() && ("," + classes + ",").find("," + target.object_class + ",") == std::string::npos) continue;
    const std::string record = "target " + std::to_string(target.id.value);
    const auto shape = target.refined ? std::optional(target.refined->cylinder) : target.bcylinder;
    if (!shape) {
      rejects.push_back({record, "no_cylinder", "nothing says how large the target is"});
      continue;
    }
    if (const std::string reason = planning::unfit(*shape); !reason.empty()) {
      rejects.push_back({record, reason,
                         "its cylinder is " + base::to_text(shape->height()) + " m high with a radius of " +
                             base::to_text(shape->radius) + " m; both must be above 0"});
      continue;
    }
    cylinders.push_back({target.id, *shape});
  }
  return cylinders;
}

CirclePlan plan_circles(const std::vector<Cylinder>& cylinders, const survey::Camera& camera,
                        const planning::SurfaceHeights& surface, const PlanStageOptions& options,
                        base::RunContext& ctx) {
  CirclePlan plan;
  std::vector<Vec3> places;
  for (const auto& c : cylinders) places.push_back(c.shape.centre());
  planning::CircleOptions circle_options = options.circles;
  circle_options.mode = options.trajectory.mode;
  std::int64_t group = 0;
  for (const std::size_t i : planning::short_tour(places, places.empty() ? Vec3(Vec3::Zero()) : places.front())) {
    ctx.check_stop();
    const Cylinder& c = cylinders[i];
    // From where the vehicle comes: the first point of the circles is the closest.
    const double start =
        plan.waypoints.empty() ? 0.0 : planning::aim_at(c.shape.centre(), plan.waypoints.back().position).heading_deg;
    auto circles = planning::mapping_circles(c.shape, camera, circle_options, start);
    double shortfall = 0.0;
    for (const auto& w : circles.waypoints)
      if (const auto least = planning::least_up(w.position.head<2>(), surface, options.clearance))
        shortfall = std::max(shortfall, *least - w.position.z());
    if (shortfall > 0.0) {
      plan.rejects.push_back({"target " + std::to_string(c.id.value), "too_close_to_surface",
                              "its circles would lie " + base::to_fixed(shortfall, 2) + " m below --clearance-m " +
                                  base::to_text(options.clearance.clearance_m) + " m above the surface"});
      continue;
    }
    const double turn = plan.waypoints.empty() ? 0.0
                                               : planning::unwrapped(circles.waypoints.front().heading_deg,
                                                                     plan.waypoints.back().heading_deg) -
                                                     circles.waypoints.front().heading_deg;
    std::size_t image = 0;
    for (auto w : circles.waypoints) {
      w.heading_deg += turn;
      w.group += group;
      if (w.photo) {
        survey::Frame view = circles.images[image++];
        view.id = survey::FrameId(static_cast<std::int64_t>(plan.views.size()));
        plan.views.push_back(view);
        plan.view_waypoint.push_back(plan.waypoints.size());
      }
      plan.waypoints.push_back(w);
    }
    group += static_cast<std::int64_t>(circles.circles);
    plan.least_side = std::min(plan.least_side, circles.coverage.side);
    plan.least_top = std::min(plan.least_top, circles.coverage.top);
    plan.rows.push(io::Json::object({{"target", c.id.value},
                                     {"circles", circles.circles},
                                     {"points_a_circle", circles.points_a_circle},
                                     {"radius_m", circles.radius_m},
                                     {"lowest_up_m", circles.waypoints.front().position.z()},
                                     {"highest_up_m", circles.waypoints.back().position.z()},
                                     {"vertical_overlap", circles.overlap},
                                     {"side_seen", circles.coverage.side},
                                     {"top_seen", circles.coverage.top},
                                     {"side_seen_in_views", circles.coverage.side_wanted},
                                     {"top_seen_in_views", circles.coverage.top_wanted}}));
  }
  return plan;
}

Outcome plan_targets(const PlanInputs& in, const fs::path& out, const PlanStageOptions& options,
                     base::RunContext& ctx) {
  require(in.targets, "a file of targets", "--targets");
  const io::TargetsFile file = io::read_targets(in.targets);
  Site site{file.frame, plan_camera(options.camera), false};
  if (const auto given = site_of_survey(in.survey)) {
    io::require_same_frame(file.frame, given->origin, in.targets.string());
    site = *given;
  }
  std::vector<base::Reject> rejects;
  const auto cylinders = cylinders_of(file, options.gaps.classes, rejects);
  const geodesy::LocalFrame frame(site.origin.position);
  // Without a terrain the targets' own feet are the ground.
  std::optional<planning::SurfaceHeights> surface;
  if (!in.terrain.empty()) {
    surface = read_surface_heights(in.terrain, frame, options.surface_cell_m, ctx);
  } else {
    double lowest = 0.0;
    for (std::size_t i = 0; i < cylinders.size(); ++i)
      lowest = i == 0 ? cylinders[i].shape.bottom : std::min(lowest, cylinders[i].shape.bottom);
    surface.emplace(lowest);
  }
  CirclePlan plan = plan_circles(cylinders, site.camera, *surface, options, ctx);
  for (auto& r : plan.rejects) rejects.push_back(std::move(r));
  if (plan.waypoints.empty())
    throw Error(ErrorCode::failed_precondition, "no target can be circled")
        .file(in.targets.string())
        .found(rejects.empty() ? "no located target" : rejects.front().record + ": " + rejects.front().message)
        .allowed("at least one target with a cylinder of height and radius above 0");

  survey::Mission mission;
  mission.name = options.name;
  mission.kind = survey::MissionKind::cylinder;
  mission.origin = site.origin;
  note_camera(mission, site, ctx);
  if (in.terrain.empty())
    mission.notes.emplace_back("no terrain given: the ground is taken as level at the foot of the lowest target");
  mission.waypoints = std::move(plan.waypoints);
  mission.views = std::move(plan.views);
  connect_safely(mission.waypoints, plan.view_waypoint, *surface, options.clearance);
  Outcome outcome = finish(mission, plan.view_waypoint, out, *surface, options, ctx);
  outcome.summary.set("targets", plan.rows.size());
  outcome.summary.set("least_side_seen", plan.least_side);
  outcome.summary.set("least_top_seen", plan.least_top);
  outcome.summary.set("per_target", std::move(plan.rows));
  outcome.rejects = std::move(rejects);
  return outcome;
}

Outcome plan_re_flight(const PlanInputs& in, const fs::path& out, const PlanStageOptions& options,
                       base::RunContext& ctx) {
  require(in.coverage, "a result of 'cairn coverage'", "its folder");
  GapPlan plan = plan_gaps(in, options, ctx);
  Outcome outcome = finish(plan.mission, plan.view_waypoint, out, plan.surface, options, ctx);
  for (auto& [name, value] : plan.figures) outcome.summary.set(name, std::move(value));
  write_gap_coverage(plan, out);
  outcome.rejects = std::move(plan.rejects);
  return outcome;
}

}  // namespace

Outcome plan_stage(const PlanInputs& in, const fs::path& out, const PlanStageOptions& given, base::RunContext& ctx) {
  PlanStageOptions options = given;
  base::validate(base::bind_options(options), "plan");
  if (options.name.empty()) options.name = options.kind;
  if (options.kind == "lawnmower") return plan_area(in, out, options, ctx);
  if (options.kind == "cylinder") return plan_targets(in, out, options, ctx);
  return plan_re_flight(in, out, options, ctx);
}

}  // namespace cairn::pipeline
