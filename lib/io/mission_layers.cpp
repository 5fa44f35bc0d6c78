#include "io/mission_layers.hpp"

#include <cmath>
#include <utility>

#include "geodesy/local_frame.hpp"
#include "io/geojson.hpp"
#include "io/json.hpp"

namespace cairn::io {
namespace {

using geometry::Vec3;

std::vector<Column> joined(std::vector<Column> first, const std::vector<Column>& then) {
  first.insert(first.end(), then.begin(), then.end());
  return first;
}

std::vector<Column> place_columns() {
  return {{"latitude_deg", ColumnType::real, "deg", "WGS84 latitude"},
          {"longitude_deg", ColumnType::real, "deg", "WGS84 longitude"},
          {"height_m", ColumnType::real, "m", "height, of the type that height_type names"},
          {"height_type", ColumnType::text, "", "what height_m is measured from"},
          {"east_m", ColumnType::real, "m", "local frame: east of the origin"},
          {"north_m", ColumnType::real, "m", "local frame: north of the origin"},
          {"up_m", ColumnType::real, "m", "local frame: up from the origin"},
          {"heading_deg", ColumnType::real, "deg", "direction of the camera, clockwise from north"},
          {"pitch_deg", ColumnType::real, "deg", "camera against the horizon; -90 looks straight down"}};
}

Layer made(const survey::Mission& mission, std::string name, std::string title, GeometryKind kind) {
  Layer layer;
  layer.name = std::move(name);
  layer.title = "DRAFT: " + std::move(title);
  layer.kind = kind;
  layer.height_type = mission.origin.height_type;
  layer.geoid = mission.origin.geoid;
  return layer;
}

double compass(double heading_deg) {
  const double h = std::fmod(heading_deg, 360.0);
  return h < 0.0 ? h + 360.0 : h;
}

class Placed {
 public:
  explicit Placed(const survey::Mission& mission)
      : frame_(mission.origin.position), type_(height_type_text(mission.origin.height_type, mission.origin.geoid)) {}

  [[nodiscard]] geometry::Geodetic at(const Vec3& p) const { return frame_.to_geodetic(p); }
  void add(Feature& feature, const Vec3& p, double heading_deg, double pitch_deg) const {
    const auto g = at(p);
    feature.parts = {{{g}}};
    for (const double v : {g.latitude_deg, g.longitude_deg, g.height_m}) feature.values.emplace_back(v);
    feature.values.emplace_back(type_);
    for (const double v : {p.x(), p.y(), p.z(), compass(heading_deg), pitch_deg}) feature.values.emplace_back(v + 0.0);
  }

 private:
  geodesy::LocalFrame frame_;
  std::string type_;
};

}  // namespace

Layer waypoint_layer(const survey::Mission& mission) {
  Layer layer = made(mission, "waypoints", "points to fly to", GeometryKind::point);
  layer.columns =
      joined(joined({{"index", ColumnType::integer, "", "place in the order of flight, from 1"},
                     {"name", ColumnType::text, "", "role, group and index"},
                     {"role", ColumnType::text, "", "lane, circle, view or transit"},
                     {"group", ColumnType::integer, "", "lane, circle or target it belongs to, from 0"}},
                    place_columns()),
             {{"stop", ColumnType::boolean, "", "comes to rest here"},
              {"photo", ColumnType::boolean, "", "takes one image here"},
              {"trigger_m", ColumnType::real, "m", "distance of the images taken from here to the next; 0 = none"},
              {"time_s", ColumnType::real, "s", "arrival, from the first"}});
  const Placed placed(mission);
  std::int64_t index = 0;
  for (const auto& w : mission.waypoints) {
    Feature feature;
    const std::string role(survey::name_of(w.role));
    ++index;
    feature.values = {index, role + " " + std::to_string(w.group) + " / " + std::to_string(index), role, w.group};
    placed.add(feature, w.position, w.heading_deg, w.pitch_deg);
    feature.values.insert(feature.values.end(), {w.stop, w.photo, w.trigger_m, w.time_s});
    layer.features.push_back(std::move(feature));
  }
  return layer;
}

Layer path_layer(const survey::Mission& mission) {
  Layer layer = made(mission, "path", "straight lines between the waypoints", GeometryKind::line);
  layer.columns = {{"name", ColumnType::text, "", "name of the mission"},
                   {"length_m", ColumnType::real, "m", "length of the lines"}};
  const Placed placed(mission);
  Feature feature;
  auto& line = feature.parts.emplace_back().emplace_back();
  double length = 0.0;
  for (std::size_t i = 0; i < mission.waypoints.size(); ++i) {
    const Vec3& p = mission.waypoints[i].position;
    if (i > 0) length += (p - mission.waypoints[i - 1].position).norm();
    line.push_back(placed.at(p));
  }
  feature.values = {"DRAFT " + mission.name, length};
  if (line.size() > 1) layer.features.push_back(std::move(feature));
  return layer;
}

Layer view_layer(const survey::Mission& mission) {
  Layer layer = made(mission, "views", "images to be taken", GeometryKind::point);
  layer.columns = joined({{"id", ColumnType::integer, "", "id of the image in mission.json"},
                          {"name", ColumnType::text, "", "image and id"}},
                         place_columns());
  const Placed placed(mission);
  for (const auto& view : mission.views) {
    const Vec3 axis = view.T_world_camera.rotation.col(2), top = -view.T_world_camera.rotation.col(1);
    // Straight down the image's upper edge tells the heading.
    const Vec3 ahead = axis.head<2>().norm() > 1e-6 ? axis : top;
    constexpr double kDegrees = 57.29577951308232;
    Feature feature;
    feature.values = {view.id.value, "image " + std::to_string(view.id.value)};
    placed.add(feature, view.T_world_camera.translation, kDegrees * std::atan2(ahead.x(), ahead.y()),
               kDegrees * std::atan2(axis.z(), axis.head<2>().norm()));
    layer.features.push_back(std::move(feature));
  }
  return layer;
}

std::string mission_geojson(const survey::Mission& mission) {
  Json features = Json::array();
  for (const Layer& layer : {path_layer(mission), waypoint_layer(mission), view_layer(mission)}) {
    const Json collection = parse_json(geojson_text(layer), layer.name);
    for (const Json& feature : collection.at("features").as_array()) {
      Json properties = Json::object({{"layer", layer.name}});
      for (const auto& [name, value] : feature.at("properties").as_object()) properties.set(name, value);
      Json copy = feature;
      copy.set("properties", std::move(properties));
      features.push(std::move(copy));
    }
  }
  return Json::object(
             {{"type", "FeatureCollection"}, {"name", "DRAFT " + mission.name}, {"features", std::move(features)}})
             .dump() +
         "\n";
}

}  // namespace cairn::io
