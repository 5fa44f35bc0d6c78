// Rasters, vector layers, ROS maps, photographs and JSON files.
#include <optional>
#include <string>
#include <vector>

#include "base/time.hpp"
#include "io/image.hpp"
#include "io/image_metadata.hpp"
#include "io/raster.hpp"
#include "io/ros_map.hpp"
#include "io/vector.hpp"
#include "pipeline/info_kinds.hpp"

namespace cairn::pipeline::info {
namespace fs = std::filesystem;
namespace {

using io::Json;

Json optional_json(const std::optional<double>& value) {
  return value ? Json(*value) : Json();
}

Json grid_json(const geometry::GridGeometry& grid) {
  return Json::object({{"columns", grid.columns},
                       {"rows", grid.rows},
                       {"cell", grid.cell},
                       {"west", grid.west},
                       {"south", grid.south()},
                       {"east", grid.east()},
                       {"north", grid.north}});
}

Json text_or_null(const std::string& text) {
  return text.empty() ? Json() : Json(text);
}

}  // namespace

Json describe_raster(const fs::path& path, const InfoOptions& /*options*/) {
  const io::RasterInfo raster = io::raster_info(path);
  std::vector<std::string> warnings;
  Json json = begin(path, "raster", "GeoTIFF");
  json.set("crs", crs_json(raster.crs, warnings));
  json.set("grid", grid_json(raster.geometry));
  Json bands = Json::array();
  for (const auto& band : raster.bands)
    bands.push(Json::object({{"name", band.name},
                             {"type", band.type},
                             {"unit", text_or_null(band.unit)},
                             {"description", text_or_null(band.description)}}));
  json.set("bands", std::move(bands));
  json.set("warnings", warnings);
  return json;
}

Json describe_vector(const fs::path& path, const InfoOptions& /*options*/) {
  const auto layers = io::vector_info(path);
  std::vector<std::string> warnings;
  Json json = begin(path, "vector", path.extension() == ".gpkg" ? "GeoPackage" : "vector");
  if (path.extension() == ".geojson" || path.extension() == ".json") json.set("format", "GeoJSON");
  if (path.extension() == ".shp") json.set("format", "Shapefile");
  Json list = Json::array();
  for (const auto& layer : layers) {
    Json columns = Json::array();
    for (const auto& column : layer.columns)
      columns.push(
          Json::object({{"name", column.name}, {"type", name_of(column.type)}, {"unit", text_or_null(column.unit)}}));
    list.push(Json::object({{"name", layer.name},
                            {"geometry", name_of(layer.kind)},
                            {"features", layer.feature_count},
                            {"crs", crs_json(layer.crs, warnings)},
                            {"columns", std::move(columns)}}));
  }
  json.set("layers", std::move(list));
  json.set("warnings", warnings);
  return json;
}

Json describe_ros_map(const fs::path& path, const InfoOptions& /*options*/) {
  const io::RosMap map = io::read_ros_map(path);
  Json json = begin(path, "ros_map", "ROS map");
  json.set("mode", io::name_of(map.mode));
  json.set("occupied_thresh", map.occupied_thresh);
  json.set("free_thresh", map.free_thresh);
  json.set("grid", grid_json(map.occupancy.geometry));
  std::size_t unknown = 0, free = 0, occupied = 0;
  for (const std::uint8_t cell : map.occupancy.values) {
    if (cell == io::kOccupancyUnknown) ++unknown;
    else if (cell == 100) ++occupied;
    else if (cell == 0) ++free;
  }
  json.set("cells", Json::object({{"free", free}, {"occupied", occupied}, {"unknown", unknown}}));
  std::vector<std::string> warnings;
  // Pixel 205 stands for unknown: occupancy (255 - 205) / 255.
  constexpr double kUnknownPixel = 50.0 / 255.0;
  if (map.mode == io::MapMode::trinary && map.free_thresh > kUnknownPixel)
    warnings.emplace_back("free_thresh is above 0.196: cells written as unknown (205) load as free");
  json.set("warnings", warnings);
  return json;
}

Json describe_image(const fs::path& path, const InfoOptions& /*options*/) {
  const io::ImageHeader header = io::read_image_header(path);
  Json json = begin(path, "image", header.format);
  json.set("width_px", header.width_px);
  json.set("height_px", header.height_px);
  json.set("channels", header.channels);
  std::vector<std::string> warnings;
  if (header.format == "JPEG") {
    const io::ImageMetadata m = io::read_image_metadata(path);
    json.set("make", text_or_null(m.make));
    json.set("model", text_or_null(m.model));
    json.set("software", text_or_null(m.software));
    json.set("civil_time", m.civil_time_ns ? Json(base::iso8601(*m.civil_time_ns)) : Json());
    json.set("orientation", m.orientation);
    json.set("focal_length_mm", optional_json(m.focal_length_mm));
    json.set("latitude_deg", optional_json(m.latitude_deg));
    json.set("longitude_deg", optional_json(m.longitude_deg));
    json.set("gps_altitude_m", optional_json(m.gps_altitude_m));
    json.set("dji", Json::object({{"gimbal_yaw_deg", optional_json(m.dji.gimbal_yaw_deg)},
                                  {"gimbal_pitch_deg", optional_json(m.dji.gimbal_pitch_deg)},
                                  {"gimbal_roll_deg", optional_json(m.dji.gimbal_roll_deg)},
                                  {"flight_yaw_deg", optional_json(m.dji.flight_yaw_deg)},
                                  {"relative_altitude_m", optional_json(m.dji.relative_altitude_m)},
                                  {"absolute_altitude_m", optional_json(m.dji.absolute_altitude_m)}}));
    if (m.orientation != 1)
      warnings.emplace_back("the EXIF orientation is not 1: viewers turn this image, cairn works in its raw pixels");
    if (m.exif_size && *m.exif_size != io::ImageSize{header.width_px, header.height_px})
      warnings.emplace_back("EXIF states another size than the image has: it was resized after it was taken");
  }
  json.set("warnings", warnings);
  return json;
}

Json describe_json(const fs::path& path, const InfoOptions& options) {
  const Json document = io::read_json(path);
  const Json* type = document.find("type");
  if (type != nullptr && type->is_string() &&
      (type->as_string() == "FeatureCollection" || type->as_string() == "Feature"))
    return describe_vector(path, options);
  Json json = begin(path, "json", "JSON");
  if (document.is_array()) json.set("items", document.size());
  if (document.is_object()) {
    Json members = Json::object();
    for (const auto& [name, value] : document.as_object()) {
      if (value.is_array()) members.set(name, Json::object({{"items", value.size()}}));
      else if (value.is_object()) members.set(name, Json::object({{"members", value.size()}}));
      else members.set(name, value);
    }
    json.set("members", std::move(members));
  }
  return json;
}

}  // namespace cairn::pipeline::info
