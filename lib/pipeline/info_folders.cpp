// Survey folders, COLMAP models and folders that a run made.
#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "base/time.hpp"
#include "io/colmap.hpp"
#include "io/survey_folder.hpp"
#include "pipeline/info_kinds.hpp"

namespace cairn::pipeline::info {
namespace fs = std::filesystem;
namespace {

using io::Json;

Json camera_json(const survey::Camera& camera) {
  return Json::object({{"id", static_cast<std::int64_t>(camera.id.value)},
                       {"model", survey::name_of(camera.model)},
                       {"width_px", camera.width_px},
                       {"height_px", camera.height_px},
                       {"fx_px", camera.fx_px}});
}

}  // namespace

Json describe_survey(const fs::path& path, const InfoOptions& /*options*/) {
  const survey::Survey survey = io::read_survey(path);
  const auto& m = survey.manifest;
  Json json = begin(path, "survey", "survey folder");
  json.set("name", m.name);
  json.set("schema_version", m.schema_version);
  json.set("origin", Json::object({{"latitude_deg", m.origin.position.latitude_deg},
                                   {"longitude_deg", m.origin.position.longitude_deg},
                                   {"height_m", m.origin.position.height_m},
                                   {"height_type", survey::name_of(m.origin.height_type)}}));
  json.set("time_base", base::name_of(m.time_base));
  Json cameras = Json::array();
  for (const auto& camera : m.cameras) cameras.push(camera_json(camera));
  json.set("cameras", std::move(cameras));
  Json sources = Json::array();
  for (const auto& source : m.sources)
    sources.push(Json::object({{"kind", source.kind},
                               {"path", source.path},
                               {"confidence", survey::name_of(source.confidence)},
                               {"crs", source.crs.empty() ? Json() : Json(source.crs)},
                               {"height_type", survey::name_of(source.height_type)},
                               {"has_transform", source.T_world_source.has_value()}}));
  json.set("sources", std::move(sources));
  json.set("frames", survey.frames.size());
  geometry::Box3 box;
  for (const auto& frame : survey.frames) box.extend(frame.T_world_camera.translation);
  json.set("camera_bounds_m", to_json(box));
  json.set("detections", survey.detections.size());
  std::map<std::string, std::size_t> classes;
  for (const auto& detection : survey.detections) ++classes[detection.object_class];
  Json counts = Json::object();
  for (const auto& [name, count] : classes) counts.set(name, count);
  json.set("detection_classes", std::move(counts));
  json.set("tie_points", survey.ties.size());
  json.set("notes", m.notes);
  return json;
}

Json describe_colmap(const fs::path& path, const InfoOptions& /*options*/) {
  const io::ColmapModel model = io::read_colmap(path);
  Json json = begin(path, "colmap_model", model.binary ? "COLMAP binary" : "COLMAP text");
  Json cameras = Json::array();
  for (const auto& camera : model.cameras) cameras.push(camera_json(camera));
  json.set("cameras", std::move(cameras));
  json.set("images", model.images.size());
  json.set("points", model.points.size());
  std::size_t observations = 0;
  geometry::Box3 centres, points;
  for (const auto& image : model.images) {
    observations += image.observations.size();
    centres.extend(image.T_world_camera.translation);
  }
  double error = 0.0;
  std::size_t with_error = 0;
  for (const auto& point : model.points) {
    points.extend(point.position);
    if (point.error_px >= 0.0) {
      error += point.error_px;
      ++with_error;
    }
  }
  json.set("observations", observations);
  json.set("mean_reprojection_error_px", with_error > 0 ? Json(error / static_cast<double>(with_error)) : Json());
  json.set("camera_bounds", to_json(centres));
  json.set("point_bounds", to_json(points));
  json.set("warnings", model.notes);
  return json;
}

Json describe_run(const fs::path& path, const InfoOptions& /*options*/) {
  const Json run = io::read_json(path / "run.json");
  Json json = begin(path, "run", "folder of results");
  for (const char* member : {"cairn_version", "command", "started_utc", "seconds", "seed", "summary", "warnings"})
    if (const Json* value = run.find(member); value != nullptr) json.set(member, *value);
  Json files = Json::array();
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(path))
    if (entry.is_regular_file()) names.push_back(entry.path().lexically_relative(path).generic_string());
  std::sort(names.begin(), names.end());
  for (auto& name : names) files.push(std::move(name));
  json.set("files", std::move(files));
  return json;
}

}  // namespace cairn::pipeline::info
