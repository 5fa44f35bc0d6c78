#include "pipeline/layers_stage.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "camera/projection.hpp"
#include "io/gaps_json.hpp"
#include "io/geojson.hpp"
#include "io/kml.hpp"
#include "io/layer_csv.hpp"
#include "io/obstacles_json.hpp"
#include "io/rocks_json.hpp"
#include "io/survey_folder.hpp"
#include "io/survey_json.hpp"
#include "io/targets_json.hpp"
#include "io/vector.hpp"
#include "report/layers.hpp"

namespace cairn::pipeline {
namespace {

std::optional<double> median(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::optional<double> ground_up(const report::LayerRecords& records) {
  std::vector<double> feet;
  for (const auto& rock : records.rocks)
    if (!rock.rejected && rock.mass) feet.push_back(rock.base_height_m);
  if (feet.empty())
    for (const auto& obstacle : records.obstacles) feet.push_back(obstacle.position.z());
  if (feet.empty())
    for (const auto& target : records.targets)
      feet.push_back(target.bcylinder ? target.bcylinder->bottom : target.centre.z());
  return median(std::move(feet));
}

std::vector<geometry::Ring> footprints(const survey::Survey& survey, double up, double max_range_m,
                                       base::RunContext& ctx) {
  constexpr int kPointsPerSide = 8;
  std::vector<geometry::Ring> rings;
  for (const auto& frame : survey.frames) {
    ctx.check_stop();
    const survey::Camera* camera = survey.camera(frame.camera);
    rings.push_back(camera == nullptr
                        ? geometry::Ring()
                        : camera::footprint(*camera, frame.T_world_camera, up, kPointsPerSide, max_range_m));
  }
  return rings;
}

report::LayerRecords read_records(const LayersInputs& in, const survey::Survey& survey) {
  report::LayerRecords records;
  records.origin = survey.manifest.origin;
  records.time_base = survey.manifest.time_base;
  records.frames = survey.frames;
  const auto take = [&](const std::filesystem::path& path, auto read, auto move_into) {
    if (path.empty()) return;
    auto file = read(path);
    io::require_same_frame(file.frame, records.origin, path.string());
    move_into(file);
  };
  take(in.targets, io::read_targets, [&](auto& file) { records.targets = std::move(file.targets); });
  take(in.rocks, io::read_rocks, [&](auto& file) { records.rocks = std::move(file.rocks); });
  take(in.obstacles, io::read_obstacles, [&](auto& file) { records.obstacles = std::move(file.obstacles); });
  take(in.gaps, io::read_gaps, [&](auto& file) { records.gaps = std::move(file.gaps); });
  return records;
}

}  // namespace

Outcome layers_stage(const LayersInputs& in, const std::filesystem::path& out, const LayersOptions& options,
                     base::RunContext& ctx) {
  LayersOptions checked = options;
  base::validate(base::bind_options(checked), "layers");
  const survey::Survey survey = io::read_survey(in.survey);
  report::LayerRecords records = read_records(in, survey);
  ctx.check_stop();
  records.ground_up_m = ground_up(records);
  if (options.footprints && records.ground_up_m)
    records.footprints = footprints(survey, *records.ground_up_m, options.max_footprint_range_m, ctx);
  if (options.footprints && !records.ground_up_m && !records.frames.empty())
    ctx.warn("No footprints: no rock, obstacle or target says where the ground is");

  const std::vector<io::Layer> layers = report::build_layers(records);
  io::write_geopackage(out / "layers.gpkg", layers);
  const io::Layer inventory = report::inventory_layer(records);
  io::write_layer_csv(out / "inventory.csv", inventory);
  io::write_geojson(out / "inventory.geojson", inventory);
  if (options.kml) io::write_kml(out / "inventory.kml", {inventory}, "cairn inventory");

  Outcome outcome;
  io::Json counts = io::Json::object();
  for (const auto& layer : layers) counts.set(layer.name, layer.features.size());
  outcome.summary =
      io::Json::object({{"features", std::move(counts)},
                        {"inventory_rows", inventory.features.size()},
                        {"height_type", io::height_type_text(records.origin.height_type, records.origin.geoid)}});
  if (records.ground_up_m) outcome.summary.set("ground_up_m", *records.ground_up_m);
  return outcome;
}

}  // namespace cairn::pipeline
