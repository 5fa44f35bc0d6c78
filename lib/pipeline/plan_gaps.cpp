#include "pipeline/plan_gaps.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "coverage/audit.hpp"
#include "coverage/coverage.hpp"
#include "coverage/gaps.hpp"
#include "coverage/target_audit.hpp"
#include "geodesy/local_frame.hpp"
#include "pipeline/audited_surface.hpp"
#include "pipeline/coverage_targets.hpp"
#include "pipeline/coverage_views.hpp"
#include "pipeline/plan_audited.hpp"
#include "pipeline/plan_mission.hpp"
#include "planning/camera_aim.hpp"
#include "planning/view_candidates.hpp"
#include "planning/view_selection.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;
using geometry::TriangleMesh;
using geometry::Vec3;
using planning::Demand;

// Demands and what they stand for.
struct Wanted {
  std::vector<Demand> demands;
  std::vector<std::string> groups;  // "target 3 wall", "gaps"
  TriangleMesh occluders;
};

// The surface's parts with one gap's reason inside a gap's outline.
void add_gaps(Wanted& wanted, const TriangleMesh& mesh, const std::vector<coverage::Verdict>& verdicts,
              const std::vector<survey::CoverageGap>& gaps, double max_gsd_m) {
  const std::size_t group = wanted.groups.size();
  wanted.groups.emplace_back("gaps");
  for (std::size_t f = 0; f < verdicts.size(); ++f) {
    if (verdicts[f] == coverage::Verdict::passed || verdicts[f] == coverage::Verdict::no_data) continue;
    const Vec3 normal = mesh.area_vector(f);
    const double area = normal.norm();
    if (!(area > 0.0)) continue;
    const Vec3 centre = mesh.centroid(f);
    const bool listed = std::any_of(gaps.begin(), gaps.end(), [&](const survey::CoverageGap& gap) {
      return gap.reason == coverage::name_of(verdicts[f]) && geometry::contains(gap.rings.front(), centre.head<2>());
    });
    if (listed) wanted.demands.push_back({centre, normal / area, area, max_gsd_m, 1.0, group});
  }
}

void add_targets(Wanted& wanted, const coverage::TargetsAudit& audit, const coverage::TargetOptions& options) {
  for (std::size_t t = 0; t < audit.targets.size(); ++t) {
    const auto& target = audit.targets[t];
    const std::string name = "target " + std::to_string(target.id.value);
    const double gsd = options.max_gsd_of_height * target.cylinder.height();
    for (const bool wall : {true, false}) {
      const std::size_t first = t * coverage::kCylinderFacets + (wall ? 0 : coverage::kWallFacets);
      const std::size_t end = (t + (wall ? 0 : 1)) * coverage::kCylinderFacets + (wall ? coverage::kWallFacets : 0);
      const std::size_t group = wanted.groups.size();
      wanted.groups.push_back(name + (wall ? " wall" : " top"));
      double total = 0.0;
      const std::size_t begin = wanted.demands.size();
      for (std::size_t f = first; f < end; ++f) {
        if (audit.verdicts[f] == coverage::Verdict::no_data) continue;
        const Vec3 normal = audit.mesh.area_vector(f);
        const double area = normal.norm();
        wanted.demands.push_back({audit.mesh.centroid(f), normal / area, area, gsd, 1.0, group});
        total += area;
      }
      // Each wall and each top is worth the same, whatever its size.
      for (std::size_t i = begin; i < wanted.demands.size(); ++i) wanted.demands[i].weight = 1.0 / total;
    }
  }
}

// Every n-th demand stands for n: at most `most`.
void thin(std::vector<Demand>& demands, std::size_t most) {
  const std::size_t every = (demands.size() + most - 1) / std::max<std::size_t>(most, 1);
  if (every <= 1) return;
  std::vector<Demand> kept;
  for (std::size_t i = 0; i < demands.size(); i += every) {
    kept.push_back(demands[i]);
    kept.back().area_m2 *= static_cast<double>(every);
  }
  demands = std::move(kept);
}

double median_range(const std::vector<Demand>& demands, const coverage::ViewSet& views) {
  std::vector<double> ranges;
  for (const Demand& d : demands)
    for (const auto& v : views.views) ranges.push_back((v.T_world_camera.translation - d.centre).norm());
  constexpr double kUsual_m = 30.0;
  if (ranges.empty()) return kUsual_m;
  const auto middle = ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() / 2);
  std::nth_element(ranges.begin(), middle, ranges.end());
  return *middle;
}

std::vector<survey::Frame> frames_of(const std::vector<planning::ViewCandidate>& candidates, survey::CameraId camera) {
  std::vector<survey::Frame> frames;
  for (const auto& c : candidates) {
    survey::Frame frame;
    frame.camera = camera;
    frame.T_world_camera = planning::camera_pose(c.position, c.heading_deg, c.pitch_deg);
    frames.push_back(frame);
  }
  return frames;
}

// Sights of the recorded views, camera by camera.
std::vector<std::vector<planning::Sight>> recorded_sights(const coverage::ViewSet& views,
                                                          const std::vector<Demand>& demands,
                                                          const visibility::Scene& scene,
                                                          const planning::ViewGates& gates, double margin,
                                                          double end_gap) {
  std::vector<std::vector<planning::Sight>> all;
  for (std::size_t c = 0; c < views.cameras.size(); ++c) {
    std::vector<survey::Frame> frames;
    for (const auto& view : views.views) {
      if (view.camera != c) continue;
      frames.emplace_back();
      frames.back().T_world_camera = view.T_world_camera;
    }
    constexpr double kAnywhere = 1e6;
    auto seen = planning::sights(frames, views.cameras[c], demands, scene, gates, kAnywhere, margin, end_gap);
    all.insert(all.end(), std::make_move_iterator(seen.begin()), std::make_move_iterator(seen.end()));
  }
  return all;
}

// A mission through the first `count` of the chosen candidates, in the order of a short tour.
void fly_through(GapPlan& plan, const std::vector<planning::ViewCandidate>& candidates,
                 const std::vector<std::size_t>& chosen, std::size_t count, const PlanStageOptions& options) {
  std::vector<Vec3> places;
  for (std::size_t i = 0; i < count; ++i) places.push_back(candidates[chosen[i]].position);
  auto& mission = plan.mission;
  mission.waypoints.clear();
  mission.views.clear();
  plan.view_waypoint.clear();
  for (const std::size_t i : planning::short_tour(places, places.empty() ? Vec3(Vec3::Zero()) : places.front())) {
    const planning::ViewCandidate& c = candidates[chosen[i]];
    survey::Waypoint w;
    w.position = c.position;
    w.heading_deg = mission.waypoints.empty()
                        ? c.heading_deg
                        : planning::unwrapped(c.heading_deg, mission.waypoints.back().heading_deg);
    w.pitch_deg = c.pitch_deg;
    w.stop = w.photo = true;
    w.role = survey::WaypointRole::view;
    w.group = static_cast<std::int64_t>(mission.waypoints.size());
    survey::Frame view;
    view.id = survey::FrameId(static_cast<std::int64_t>(mission.views.size()));
    view.camera = mission.camera.id;
    view.T_world_camera = planning::camera_pose(w.position, w.heading_deg, w.pitch_deg);
    plan.view_waypoint.push_back(mission.waypoints.size());
    mission.waypoints.push_back(w);
    mission.views.push_back(view);
  }
  connect_safely(mission.waypoints, plan.view_waypoint, plan.surface, options.clearance);
  fly(mission, plan.view_waypoint, options.trajectory);
}

// Largest number of views, first chosen first, whose flight fits the budget.
std::size_t within_budget(GapPlan& plan, const std::vector<planning::ViewCandidate>& candidates,
                          const std::vector<std::size_t>& chosen, const PlanStageOptions& options) {
  const auto fits = [&](std::size_t count) {
    fly_through(plan, candidates, chosen, count, options);
    return options.budget_s <= 0.0 || mission_time(plan.mission) <= options.budget_s;
  };
  if (fits(chosen.size())) return chosen.size();
  std::size_t good = 0, bad = chosen.size();
  while (bad - good > 1) {
    const std::size_t middle = good + (bad - good) / 2;
    (fits(middle) ? good : bad) = middle;
  }
  if (good > 0) fly_through(plan, candidates, chosen, good, options);
  return good;
}

io::Json target_rows(const coverage::TargetsAudit& before, const coverage::TargetsAudit& after) {
  io::Json rows = io::Json::array();
  for (std::size_t i = 0; i < before.targets.size(); ++i)
    rows.push(io::Json::object({{"target", before.targets[i].id.value},
                                {"wall_before", before.targets[i].wall.completeness()},
                                {"wall_after", after.targets[i].wall.completeness()},
                                {"top_before", before.targets[i].top.completeness()},
                                {"top_after", after.targets[i].top.completeness()},
                                {"basal_band_before", before.targets[i].basal.seen_share},
                                {"basal_band_after", after.targets[i].basal.seen_share}}));
  return rows;
}

}  // namespace

GapPlan plan_gaps(const PlanInputs& in, const PlanStageOptions& options, base::RunContext& ctx) {
  Audited audited = read_audited(in);
  CoverageViews views = read_coverage_views(audited.views, audited.format);
  if (!views.origin)
    throw Error(ErrorCode::failed_precondition, "a re-flight needs views in a georeferenced frame")
        .file(audited.views.string())
        .hint("Audit a survey or a mission, not a camera table");
  const geodesy::LocalFrame frame(views.origin->position);
  const AuditedSurface surface = read_audited_surface(audited.surface, frame, ctx);
  const visibility::Scene scene(surface.mesh, visibility::Tracing::fast);
  audited.visibility.metrics = true;

  std::vector<coverage::TargetBody> bodies;
  GapPlan plan;
  if (!audited.targets.empty()) {
    auto read = read_coverage_targets(audited.targets, audited.contacts, views.origin);
    bodies = std::move(read.bodies);
    plan.rejects = std::move(read.rejects);
    keep_classes(bodies, plan.rejects, audited.targets, options.gaps.classes);
  }
  const bool see_targets = options.gaps.scope == "targets" || options.gaps.scope == "both" ||
                           (options.gaps.scope == "auto" && !bodies.empty());
  const bool see_gaps =
      options.gaps.scope == "gaps" || options.gaps.scope == "both" || (options.gaps.scope == "auto" && bodies.empty());
  if (see_targets && bodies.empty())
    throw Error(ErrorCode::failed_precondition, "there are no targets to see again")
        .file(audited.targets.string())
        .hint("Give --targets, or --scope gaps");
  coverage::TargetOptions target_options = audited.target_options;
  if (surface.grid) target_options.clearance_m = std::max(target_options.clearance_m, 1.5 * surface.grid->cell);
  const auto audit_targets = [&](const coverage::ViewSet& set) {
    return coverage::audit_targets(surface.mesh, surface.observed, scene, bodies, set, audited.visibility,
                                   audited.gates, target_options, ctx);
  };
  const auto audit_surface = [&](const coverage::ViewSet& set) {
    return coverage::audit(surface.mesh, coverage::coverage(surface.mesh, scene, set, audited.visibility, ctx),
                           surface.observed, audited.gates);
  };

  Wanted wanted;
  coverage::TargetsAudit targets_before;
  coverage::Audit surface_before;
  wanted.occluders = surface.mesh;
  if (see_targets) {
    targets_before = audit_targets(views.set);
    for (const auto& r : targets_before.rejects) plan.rejects.push_back(r);
    add_targets(wanted, targets_before, target_options);
    wanted.occluders =
        coverage::target_occluders(surface.mesh, bodies, targets_before.mesh, target_options.clearance_m);
  }
  if (see_gaps) {
    surface_before = audit_surface(views.set);
    const auto gaps = coverage::find_gaps(surface.mesh, surface_before.verdicts, views.set, audited.gaps);
    add_gaps(wanted, surface.mesh, surface_before.verdicts, gaps, 1e-3 * audited.gates.max_gsd_mm);
  }
  thin(wanted.demands, static_cast<std::size_t>(options.gaps.max_demands));
  ctx.check_stop();

  plan.surface = planning::SurfaceHeights(
      planning::highest_of(wanted.occluders, surface.grid ? surface.grid->cell : options.surface_cell_m));
  auto& mission = plan.mission;
  mission.name = options.name;
  mission.kind = survey::MissionKind::gaps;
  mission.origin = *views.origin;
  mission.camera = views.set.cameras.front();

  const visibility::Scene standing(wanted.occluders, visibility::Tracing::fast);
  const planning::ViewGates gates{audited.gates.min_views, audited.gates.max_incidence_deg,
                                  audited.gates.min_parallax_deg};
  const double end_gap = audited.visibility.end_gap;
  const auto already =
      recorded_sights(views.set, wanted.demands, standing, gates, audited.visibility.frame_margin, end_gap);
  planning::CandidateOptions candidate_options;
  candidate_options.range_m = options.gaps.range_m;
  candidate_options.most_range_m = median_range(wanted.demands, views.set);
  candidate_options.cell_m = options.gaps.cell_m;
  candidate_options.max_incidence_deg = gates.max_incidence_deg;
  candidate_options.max_candidates = static_cast<std::size_t>(options.gaps.max_candidates);
  // Only what does not pass yet asks for views.
  const auto candidates =
      planning::candidate_views(wanted.demands, mission.camera, plan.surface, options.clearance, candidate_options);
  const auto frames = frames_of(candidates.candidates, mission.camera.id);
  // Farther off a view finds little at its sampling distance.
  const double reach = 2.5 * candidates.farthest_m;
  // A little inside the frame: the vehicle holds its place only so well.
  const double margin = std::max(0.02, audited.visibility.frame_margin);
  const auto seen = planning::sights(frames, mission.camera, wanted.demands, standing, gates, reach, margin, end_gap);
  ctx.check_stop();
  // A little more than asked for, so that rounding and thinning do not fall short of it.
  planning::SelectionOptions selection_options;
  selection_options.target = std::min(1.0, options.gaps.target + 0.005);
  const auto selection = planning::select_views(wanted.demands, gates, already, seen, selection_options);
  for (std::size_t g = 0; g < selection.group_reachable.size(); ++g)
    if (selection.group_reachable[g] < options.gaps.target)
      plan.rejects.push_back({wanted.groups[g], "unreachable_gap",
                              "no permitted view can bring it above " +
                                  base::to_fixed(100.0 * selection.group_reachable[g], 1) +
                                  " % (wanted: " + base::to_fixed(100.0 * options.gaps.target, 1) + " %)"});
  if (selection.chosen.empty()) {
    const bool done = selection.share_before >= options.gaps.target;
    throw Error(ErrorCode::failed_precondition, done ? "nothing has to be flown again" : "no permitted view helps")
        .file(in.coverage.string())
        .found(base::to_fixed(100.0 * selection.share_before, 1) + " % pass already, " + std::to_string(frames.size()) +
               " candidate views")
        .hint(done ? "Raise --coverage-target where more is wanted"
                   : "Lower --clearance-m, or give another --view-range-m");
  }
  const std::size_t flown = within_budget(plan, candidates.candidates, selection.chosen, options);
  if (flown == 0)
    throw Error(ErrorCode::failed_precondition, "the budget is too short for a single view")
        .found(base::to_text(options.budget_s) + " s")
        .hint("Give a longer --budget");
  if (flown < selection.chosen.size()) {
    mission.notes.push_back("the budget allows " + std::to_string(flown) + " of the " +
                            std::to_string(selection.chosen.size()) + " views that the target asks for");
    ctx.warn("The re-flight stays short of its target: " + mission.notes.back());
  }

  coverage::ViewSet both = views.set;
  for (const auto& view : mission.views) both.views.push_back({view.id, 0, view.T_world_camera});
  plan.coverage =
      io::Json::object({{"schema_version", 1}, {"kind", "predicted visibility, recorded and planned views"}});
  auto& figures = plan.figures;
  figures.emplace_back("candidates", frames.size());
  figures.emplace_back("candidates_too_low", candidates.too_low);
  figures.emplace_back("candidates_over_unknown_ground", candidates.unknown);
  figures.emplace_back("views_for_target", selection.chosen.size());
  figures.emplace_back("coverage_target", options.gaps.target);
  figures.emplace_back("least_share_before", selection.share_before);
  figures.emplace_back("least_share_reachable", selection.share_reachable);
  if (see_targets) {
    const auto after = audit_targets(both);
    double wall_before = 1.0, wall_after = 1.0, top_after = 1.0;
    double area = 0.0, passed_before = 0.0, passed_after = 0.0;
    for (std::size_t i = 0; i < after.targets.size(); ++i) {
      const double a = after.targets[i].wall.area_m2;
      area += a;
      passed_before += a * targets_before.targets[i].wall.completeness();
      passed_after += a * after.targets[i].wall.completeness();
      wall_before = std::min(wall_before, targets_before.targets[i].wall.completeness());
      wall_after = std::min(wall_after, after.targets[i].wall.completeness());
      top_after = std::min(top_after, after.targets[i].top.completeness());
    }
    figures.emplace_back("targets", after.targets.size());
    figures.emplace_back("walls_before", area > 0.0 ? passed_before / area : 0.0);
    figures.emplace_back("walls_after", area > 0.0 ? passed_after / area : 0.0);
    figures.emplace_back("least_wall_before", wall_before);
    figures.emplace_back("least_wall_after", wall_after);
    figures.emplace_back("least_top_after", top_after);
    plan.coverage.set("targets", target_rows(targets_before, after));
  }
  if (see_gaps) {
    const auto after = audit_surface(both);
    figures.emplace_back("completeness_before", surface_before.completeness());
    figures.emplace_back("completeness_after", after.completeness());
    plan.coverage.set("completeness_before", surface_before.completeness());
    plan.coverage.set("completeness_after", after.completeness());
  }
  return plan;
}

void write_gap_coverage(const GapPlan& plan, const fs::path& out) {
  base::write_file(out / "coverage.json", plan.coverage.dump() + "\n");
}

}  // namespace cairn::pipeline
