#include "pipeline/obstacles_stage.hpp"

#include <array>
#include <optional>

#include "base/error.hpp"
#include "geodesy/local_frame.hpp"
#include "io/obstacles_json.hpp"
#include "io/survey_folder.hpp"
#include "io/targets_json.hpp"
#include "pipeline/function_stage.hpp"
#include "pipeline/terrain_height.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;

Outcome obstacles_stage(const ObstaclesInputs& in, const fs::path& out, const ground::ObstacleOptions& options,
                        base::RunContext& ctx) {
  const survey::Survey survey = io::read_survey(in.survey);
  const io::TargetsFile targets = io::read_targets(in.targets);
  const geodesy::LocalFrame frame(survey.manifest.origin.position);
  if (geodesy::LocalFrame(targets.frame.position).fingerprint() != frame.fingerprint())
    throw base::Error(base::ErrorCode::crs_mismatch, "the targets are in another local frame than the survey")
        .file(in.targets.string())
        .hint("Give the targets.json that was made from this survey");
  std::optional<TerrainHeight> terrain;
  ground::GroundHeight ground;
  if (!in.terrain.empty()) {
    terrain.emplace(in.terrain, frame);
    ground = [&terrain](double east, double north) { return terrain->up(east, north); };
  }
  auto result = ground::make_obstacles(targets.targets, survey, ground, options, ctx);
  if (result.without_ground > 0)
    ctx.warn("obstacles: no ground is known below " + std::to_string(result.without_ground) +
             " objects; their foot is half their height below their centre");
  io::write_obstacles(out / "obstacles.json", {survey.manifest.origin, result.obstacles});

  std::array<std::size_t, 3> kinds{};
  for (const auto& o : result.obstacles) ++kinds.at(static_cast<std::size_t>(o.kind));
  io::Json unknown = io::Json::array();
  for (const auto& name : result.unknown_classes) unknown.push(name);
  Outcome outcome;
  outcome.summary = io::Json::object({{"targets", targets.targets.size()},
                                      {"objects", result.obstacles.size()},
                                      {"obstacle", kinds[0]},
                                      {"ignored", kinds[1]},
                                      {"vehicle", kinds[2]},
                                      {"without_ground", result.without_ground},
                                      {"unknown_classes", std::move(unknown)},
                                      {"rejects_by_reason", count_by_reason(result.rejects)}});
  outcome.rejects = std::move(result.rejects);
  return outcome;
}

std::unique_ptr<Stage> make_obstacles_stage() {
  return make_function_stage<ground::ObstacleOptions>(
      {"obstacles",
       {"locate"},
       {"terrain"},
       [](const StageInputs&, const ground::ObstacleOptions&) -> Estimate {
         return {std::uint64_t{256} << 20U, std::uint64_t{1} << 20U};
       },
       [](const StageInputs& in, const fs::path& out, const ground::ObstacleOptions& options, base::RunContext& ctx) {
         return obstacles_stage({in.survey, in.products / "targets.json", product(in, "terrain", "surface.tif")}, out,
                                options, ctx);
       }});
}

}  // namespace cairn::pipeline
