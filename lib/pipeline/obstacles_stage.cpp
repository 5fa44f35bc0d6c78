#include "pipeline/obstacles_stage.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <set>

#include "base/error.hpp"
#include "geodesy/local_frame.hpp"
#include "io/geojson.hpp"
#include "io/obstacles_json.hpp"
#include "io/packets.hpp"
#include "io/survey_folder.hpp"
#include "io/targets_json.hpp"
#include "io/vector.hpp"
#include "pipeline/function_stage.hpp"
#include "pipeline/projected_obstacles.hpp"
#include "pipeline/terrain_height.hpp"
#include "report/layers.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double plane_of(const survey::Survey& survey, const ground::GroundHeight& terrain,
                const std::vector<survey::Obstacle>& located, base::RunContext& ctx) {
  std::vector<double> heights;
  if (terrain)
    for (const auto& frame : survey.frames)
      if (const auto up = terrain(frame.T_world_camera.translation.x(), frame.T_world_camera.translation.y()))
        heights.push_back(*up);
  if (heights.empty())
    for (const auto& tie : survey.ties) heights.push_back(tie.p_world.z());
  if (heights.empty())
    for (const auto& obstacle : located) heights.push_back(obstacle.position.z());
  if (!heights.empty()) return median(std::move(heights));
  ctx.warn("obstacles: nothing says where the ground is; it is taken at up = 0. Give --terrain or --ground-up-m");
  return 0.0;
}

void write_layers(const fs::path& out, const survey::Survey& survey, const std::vector<survey::Obstacle>& obstacles,
                  const std::vector<geometry::Ring>& footprints, double plane_up) {
  report::LayerRecords records;
  records.origin = survey.manifest.origin;
  records.time_base = survey.manifest.time_base;
  records.obstacles = obstacles;
  records.frames = survey.frames;
  records.footprints = footprints;
  records.ground_up_m = plane_up;
  std::vector<io::Layer> kept;
  for (auto& layer : report::build_layers(records))
    if (layer.name == "obstacles" || layer.name == "footprints") kept.push_back(std::move(layer));
  io::write_geopackage(out / "layers.gpkg", kept);
  for (const auto& layer : kept)
    if (layer.name == "obstacles") io::write_geojson(out / "obstacles.geojson", layer);
}

std::vector<survey::Target> read_located(const fs::path& path, const geodesy::LocalFrame& frame) {
  io::TargetsFile file = io::read_targets(path);
  if (geodesy::LocalFrame(file.frame.position).fingerprint() != frame.fingerprint())
    throw base::Error(base::ErrorCode::crs_mismatch, "the targets are in another local frame than the survey")
        .file(path.string())
        .hint("Give the targets.json that was made from this survey");
  return std::move(file.targets);
}

}  // namespace

Outcome obstacles_stage(const ObstaclesInputs& in, const fs::path& out, const ObstaclesStageOptions& given,
                        base::RunContext& ctx, const ObstaclesProducts& products) {
  ObstaclesStageOptions options = given;
  base::validate(base::bind_options(options), "obstacles");
  const bool paper = options.projection.mode == "paper";
  if (options.map.memory == "as_mode") options.map.memory = options.projection.mode;
  const survey::Survey survey = io::read_survey(in.survey);
  const geodesy::LocalFrame frame(survey.manifest.origin.position);
  std::vector<survey::Target> targets;
  if (!in.targets.empty() && !paper) targets = read_located(in.targets, frame);
  if (in.targets.empty() && survey.detections.empty())
    throw base::Error(base::ErrorCode::failed_precondition, "the survey has no detections")
        .file((in.survey / "detections.csv").string())
        .hint("Attach a detector's boxes with 'cairn import ... --detections FILE'");
  std::optional<TerrainHeight> terrain;
  ground::GroundHeight ground;
  if (!in.terrain.empty()) {
    terrain.emplace(in.terrain, frame);
    ground = [&terrain](double east, double north) { return terrain->up(east, north); };
  }
  auto located = ground::make_obstacles(targets, survey, ground, options.located, ctx);
  if (located.without_ground > 0)
    ctx.warn("obstacles: no ground is known below " + std::to_string(located.without_ground) +
             " objects; their foot is half their height below their centre");

  if (options.projection.ground_up_m <= ObstaclesStageOptions::kFromSurvey)
    options.projection.ground_up_m = plane_of(survey, ground, located.obstacles, ctx);
  std::set<survey::DetectionId> explained;
  std::int64_t first_id = 1;
  std::set<survey::TargetId> kept;
  for (const auto& o : located.obstacles) kept.insert(o.target);
  for (const auto& target : targets) {
    first_id = std::max(first_id, target.id.value + 1);
    if (kept.contains(target.id)) explained.insert(target.detections.begin(), target.detections.end());
  }
  ProjectedObstacles projected;
  if (options.project || paper || products.packets || products.layers)
    projected = project_survey(survey, ground, options.located.classes, options.projection, options.map, explained,
                               first_id, ctx);
  std::size_t doubles = 0;
  if (!options.project && !paper) projected.obstacles.clear();
  else doubles = drop_explained(projected.obstacles, located.obstacles);
  for (const auto& name : projected.unknown_classes)
    if (std::find(located.unknown_classes.begin(), located.unknown_classes.end(), name) ==
        located.unknown_classes.end()) {
      located.unknown_classes.push_back(name);
      ctx.warn("obstacles: class '" + name + "' is in no table; it is taken as an obstacle");
    }
  if (!projected.times_known)
    ctx.warn("obstacles: the frames have no times of their own; nothing is taken to move, and packets are numbered");

  std::vector<survey::Obstacle> all = located.obstacles;
  all.insert(all.end(), projected.obstacles.begin(), projected.obstacles.end());
  io::write_obstacles(out / "obstacles.json", {survey.manifest.origin, all});
  if (products.layers) write_layers(out, survey, all, projected.footprints, options.projection.ground_up_m);
  if (products.packets) {
    std::vector<survey::ReceivedPacket> sent;
    for (const auto& packet : projected.packets) sent.push_back({packet.capture_time_ns, packet});
    io::write_packets(out / "packets.bin", sent, survey.manifest.time_base);
  }

  std::array<std::size_t, 3> kinds{};
  std::size_t moving = 0;
  for (const auto& o : all) {
    ++kinds.at(static_cast<std::size_t>(o.kind));
    if (o.velocity) ++moving;
  }
  io::Json unknown = io::Json::array();
  for (const auto& name : located.unknown_classes) unknown.push(name);
  Outcome outcome;
  outcome.rejects = std::move(located.rejects);
  outcome.rejects.insert(outcome.rejects.end(), projected.rejects.begin(), projected.rejects.end());
  outcome.summary = io::Json::object({{"mode", options.projection.mode},
                                      {"targets", targets.size()},
                                      {"objects", all.size()},
                                      {"obstacle", kinds[0]},
                                      {"ignored", kinds[1]},
                                      {"vehicle", kinds[2]},
                                      {"located", located.obstacles.size()},
                                      {"projected", projected.obstacles.size()},
                                      {"projected_detections", projected.detections},
                                      {"projected_doubles", doubles},
                                      {"moving", moving},
                                      {"packets", projected.packets.size()},
                                      {"ground_up_m", options.projection.ground_up_m},
                                      {"without_ground", located.without_ground},
                                      {"unknown_classes", std::move(unknown)},
                                      {"rejects_by_reason", count_by_reason(outcome.rejects)}});
  return outcome;
}

std::unique_ptr<Stage> make_obstacles_stage() {
  return make_function_stage<ObstaclesStageOptions>(
      {"obstacles",
       {"locate"},
       {"terrain"},
       [](const StageInputs&, const ObstaclesStageOptions&) -> Estimate {
         return {std::uint64_t{256} << 20U, std::uint64_t{1} << 20U};
       },
       [](const StageInputs& in, const fs::path& out, const ObstaclesStageOptions& options, base::RunContext& ctx) {
         return obstacles_stage({in.survey, in.products / "targets.json", product(in, "terrain", "surface.tif")}, out,
                                options, ctx);
       }});
}

}  // namespace cairn::pipeline
