// Stage `plan`: an area, targets or gaps -> a mission, as a draft for whoever flies it.
#pragma once

#include <filesystem>
#include <string>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "pipeline/outcome.hpp"
#include "pipeline/plan_site.hpp"
#include "planning/circles.hpp"
#include "planning/clearance.hpp"
#include "planning/lawnmower.hpp"
#include "planning/trajectory.hpp"

namespace cairn::pipeline {

struct PlanInputs {
  std::filesystem::path area;      // lawnmower: polygons
  std::filesystem::path targets;   // cylinder; gaps: targets.json
  std::filesystem::path coverage;  // gaps: folder of `cairn coverage`, or of a recipe with that stage
  std::filesystem::path terrain;   // surface to stay clear of; gaps: "" = the audited one
  std::filesystem::path survey;    // camera and frame; "" = PlanCameraOptions, and the frame of the other inputs
};

struct GapPlanOptions {
  double target = 0.95;  // share of the area to be seen that is to pass its gates
  double range_m = 0.0;  // of the candidate views; 0 = from the sampling distance, else the recorded views
  double cell_m = 1.0;   // candidates are made for pieces of the gaps of this size
  std::int64_t max_candidates = 30000;
  std::int64_t max_demands = 20000;
  std::string classes;         // of targets, separated by commas; "" = all
  std::string scope = "auto";  // auto: targets where there are any, else gaps; targets; gaps; both

  void visit(base::OptionVisitor& v) {
    v.real("coverage-target", target, 0.01, 1.0, "share of the area that is to pass the audit's gates");
    v.real("view-range-m", range_m, 0.0, 500.0, "distance of new views; 0 = from sampling distance and recorded views");
    v.real("gap-cell-m", cell_m, 0.05, 100.0, "size of the pieces of a gap that candidate views are made for");
    v.integer("max-candidates", max_candidates, 500, 1'000'000, "candidate views, at most");
    v.integer("max-demands", max_demands, 10, 10'000'000, "pieces of surface that are looked at, at most");
    v.text("classes", classes, "gaps, cylinder: classes of the targets, separated by commas; empty = all");
    v.choice("scope", scope, {"auto", "targets", "gaps", "both"},
             "what to see again: the walls and tops of targets, the gaps of the surface, or both");
  }
};

struct PlanStageOptions {
  std::string kind = "lawnmower";    // lawnmower, cylinder, gaps; not an option but an argument
  std::string name;                  // "" = the kind
  double budget_s = 0.0;             // 0 = none
  std::string height_type = "auto";  // what a terrain's heights are measured from, where no survey says it
  double home_up_m = kNoHome;        // local up of the launch point
  double surface_cell_m = 0.25;      // of the height grid over a mesh
  planning::TrajectoryOptions trajectory;
  planning::LawnmowerOptions lawnmower;
  planning::CircleOptions circles;
  planning::ClearanceOptions clearance;
  PlanCameraOptions camera;
  GapPlanOptions gaps;

  static constexpr double kNoHome = -1e6;

  void visit(base::OptionVisitor& v) {
    v.text("name", name, "name of the mission; empty = its kind");
    v.choice("height-type", height_type, {"auto", "ellipsoidal", "orthometric", "relative_takeoff", "unknown"},
             "what the terrain's heights are measured from, where no survey or targets say it");
    v.real("home-up-m", home_up_m, kNoHome, 1e5, "local up of the launch point; -1000000 = below the first waypoint");
    v.real("surface-cell-m", surface_cell_m, 0.02, 10.0, "cell of the height grid over a mesh");
    trajectory.visit(v);
    lawnmower.visit(v);
    circles.visit(v);
    clearance.visit(v);
    camera.visit(v);
    gaps.visit(v);
  }
};

// Writes into `out`:
//   mission.json      the mission, complete (survey::Mission)
//   mission.plan      QGroundControl, simple items, no take-off
//   mission.kml, mission.geojson, mission.csv
//   coverage.json     gaps: predicted coverage with the recorded views alone, and with the planned ones, a row a target
// Targets without a usable cylinder, or whose circles would come too close to the surface, are rejects. Summary:
// counts, length, duration, peaks, least clearance, and what each kind proves. Throws as the planners do;
// failed_precondition where no target is left, or the mission would fly below the surface.
Outcome plan_stage(const PlanInputs& in, const std::filesystem::path& out, const PlanStageOptions& options,
                   base::RunContext& ctx);

}  // namespace cairn::pipeline
