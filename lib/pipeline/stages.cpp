#include "pipeline/stages.hpp"

#include <array>
#include <utility>

#include "pipeline/costmap_stage.hpp"
#include "pipeline/coverage_stage.hpp"
#include "pipeline/fragility_stage.hpp"
#include "pipeline/function_stage.hpp"
#include "pipeline/inventory_stage.hpp"
#include "pipeline/layers_stage.hpp"
#include "pipeline/locate_stage.hpp"
#include "pipeline/obstacles_stage.hpp"
#include "pipeline/report_stage.hpp"
#include "pipeline/rock_figures.hpp"
#include "pipeline/route_stage.hpp"
#include "pipeline/segment_stage.hpp"
#include "pipeline/surface_stage.hpp"
#include "pipeline/terrain_stage.hpp"
#include "pipeline/vehicle_stage.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t kMebibyte = 1U << 20U;

// What a survey folder may hold as prior map of its ground vehicle.
fs::path prior_of(const fs::path& survey) {
  for (const char* name : {"prior/map.yaml", "prior.tif", "prior.gpkg", "prior.geojson"})
    if (fs::exists(survey / name)) return survey / name;
  return {};
}

CostmapInputs costmap_inputs(const StageInputs& in) {
  CostmapInputs inputs;
  inputs.obstacles = in.products / "obstacles.json";
  inputs.surface = product(in, "terrain", "surface.tif");
  inputs.prior = prior_of(in.survey);
  inputs.survey = in.survey;
  inputs.vehicle = product(in, "vehicle", "vehicle.csv");
  if (!inputs.vehicle.empty() && fs::exists(in.survey / "lidar.csv")) inputs.scans = in.survey / "lidar.csv";
  else inputs.vehicle.clear();
  return inputs;
}

// A costmap of up to 20 million cells (220 m square at 5 cm); the extent is known after `terrain` only.
std::unique_ptr<Stage> make_costmap_stage() {
  return make_function_stage<CostmapStageOptions>(
      {"costmap",
       {"obstacles"},
       {"terrain", "vehicle"},
       [](const StageInputs&, const CostmapStageOptions&) -> Estimate {
         return {400 * kMebibyte, 40 * kMebibyte};
       },
       [](const StageInputs& in, const fs::path& out, const CostmapStageOptions& options, base::RunContext& ctx) {
         return costmap_stage(costmap_inputs(in), out, options, ctx);
       }});
}

std::unique_ptr<Stage> make_route_stage() {
  return make_function_stage<RouteStageOptions>(
      {"route",
       {"costmap"},
       {},
       [](const StageInputs&, const RouteStageOptions&) -> Estimate {
         return {600 * kMebibyte, kMebibyte};
       },
       [](const StageInputs& in, const fs::path& out, const RouteStageOptions& options, base::RunContext& ctx) {
         return route_stage(in.products / "costmap.tif", out, options, ctx);
       }});
}

std::unique_ptr<Stage> make_layers_stage() {
  return make_function_stage<LayersOptions>(
      {"layers",
       {},
       {"locate", "fragility", "obstacles", "coverage"},
       [](const StageInputs&, const LayersOptions&) -> Estimate {
         return {128 * kMebibyte, 8 * kMebibyte};
       },
       [](const StageInputs& in, const fs::path& out, const LayersOptions& options, base::RunContext& ctx) {
         return layers_stage({in.survey, product(in, "locate", "targets.json"), product(in, "fragility", "rocks.json"),
                              product(in, "obstacles", "obstacles.json"), product(in, "coverage", "gaps.json")},
                             out, options, ctx);
       }});
}

std::unique_ptr<Stage> make_figures_stage() {
  return make_function_stage<FigureOptions>(
      {"figures",
       {"fragility"},
       {},
       [](const StageInputs&, const FigureOptions&) -> Estimate {
         return {300 * kMebibyte, 64 * kMebibyte};
       },
       [](const StageInputs& in, const fs::path& out, const FigureOptions& options, base::RunContext& ctx) {
         const fs::path rocks = in.products / "rocks";
         fs::create_directories(out / "rocks");
         return figure_files(read_rock_results(rocks, in.products), rocks, in.survey, out / "rocks", options, ctx);
       }});
}

using Maker = std::unique_ptr<Stage> (*)();
constexpr std::array<std::pair<std::string_view, Maker>, 14> kStages{{{"locate", make_locate_stage},
                                                                      {"terrain", make_terrain_stage},
                                                                      {"segment", make_segment_stage},
                                                                      {"surface", make_surface_stage},
                                                                      {"fragility", make_fragility_stage},
                                                                      {"figures", make_figures_stage},
                                                                      {"coverage", make_coverage_stage},
                                                                      {"obstacles", make_obstacles_stage},
                                                                      {"vehicle", make_vehicle_stage},
                                                                      {"costmap", make_costmap_stage},
                                                                      {"route", make_route_stage},
                                                                      {"layers", make_layers_stage},
                                                                      {"inventory", make_inventory_stage},
                                                                      {"report", make_report_stage}}};

}  // namespace

std::unique_ptr<Stage> make_stage(std::string_view name) {
  for (const auto& [known, make] : kStages)
    if (known == name) return make();
  return nullptr;
}

}  // namespace cairn::pipeline
