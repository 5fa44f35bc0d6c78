#include "io/mission_json.hpp"

#include <fstream>
#include <string>
#include <utility>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "io/records_json.hpp"
#include "io/survey_folder.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;
using survey::Waypoint;

constexpr std::string_view kWhat = "mission (DRAFT, advisory)";

Json waypoint_json(const Waypoint& w) {
  return Json::object({{"position_m", vec3_to_json(w.position, "position_m")},
                       {"heading_deg", finite(w.heading_deg, "heading_deg")},
                       {"pitch_deg", finite(w.pitch_deg, "pitch_deg")},
                       {"stop", w.stop},
                       {"photo", w.photo},
                       {"trigger_m", finite(w.trigger_m, "trigger_m")},
                       {"role", survey::name_of(w.role)},
                       {"group", w.group},
                       {"time_s", finite(w.time_s, "time_s")}});
}

Waypoint waypoint_from(const Json& json) {
  Waypoint w;
  w.position = json.at("position_m").as_vec3();
  w.heading_deg = json.at("heading_deg").as_real();
  w.pitch_deg = json.at("pitch_deg").as_real();
  w.stop = json.at("stop").as_bool();
  w.photo = json.at("photo").as_bool();
  w.trigger_m = json.at("trigger_m").as_real();
  const auto role = survey::waypoint_role_from(json.at("role").as_string());
  if (!role)
    throw Error(ErrorCode::invalid_input, "unknown role of a waypoint")
        .found("'" + json.at("role").as_string() + "'")
        .allowed("lane, circle, view, transit");
  w.role = *role;
  w.group = json.at("group").as_integer();
  w.time_s = json.at("time_s").as_real();
  return w;
}

Json view_json(const survey::Frame& view) {
  const auto q = geometry::quaternion(view.T_world_camera.rotation);
  return Json::object({{"id", view.id.value},
                       {"time_ns", view.time_ns},
                       {"position_m", vec3_to_json(view.T_world_camera.translation, "position_m")},
                       {"qw", finite(q.qw, "qw")},
                       {"qx", finite(q.qx, "qx")},
                       {"qy", finite(q.qy, "qy")},
                       {"qz", finite(q.qz, "qz")}});
}

survey::Frame view_from(const Json& json, survey::CameraId camera) {
  survey::Frame view;
  view.id = survey::FrameId(json.at("id").as_integer());
  view.time_ns = json.at("time_ns").as_integer();
  view.camera = camera;
  view.T_world_camera.translation = json.at("position_m").as_vec3();
  const geometry::Quaternion q{json.at("qw").as_real(), json.at("qx").as_real(), json.at("qy").as_real(),
                               json.at("qz").as_real()};
  constexpr double kUnit = 1e-3;  // as for every pose that is read
  if (std::abs(q.norm() - 1.0) > kUnit)
    throw Error(ErrorCode::invalid_input, "a view's quaternion is not of unit length").found(std::to_string(q.norm()));
  view.T_world_camera.rotation = geometry::rotation_matrix(q);
  return view;
}

Json segment_json(const survey::PolynomialSegment& segment) {
  Json rows = Json::array();
  for (const auto& row : segment.coefficients) rows.push(finite_list({row.begin(), row.end()}, "coefficients"));
  return Json::object({{"duration_s", finite(segment.duration_s, "duration_s")}, {"coefficients", std::move(rows)}});
}

survey::PolynomialSegment segment_from(const Json& json) {
  survey::PolynomialSegment segment;
  segment.duration_s = json.at("duration_s").as_real();
  if (!(segment.duration_s > 0.0))
    throw Error(ErrorCode::invalid_input, "a segment without duration").allowed("above 0");
  const auto& rows = json.at("coefficients").as_array();
  if (rows.size() != segment.coefficients.size())
    throw Error(ErrorCode::invalid_input, "a segment with another number of coordinates")
        .found(std::to_string(rows.size()))
        .allowed("4: east, north, up, yaw");
  for (std::size_t d = 0; d < rows.size(); ++d) {
    const auto values = real_list(rows[d]);
    if (values.size() != segment.coefficients[d].size())
      throw Error(ErrorCode::invalid_input, "a polynomial of another degree")
          .found(std::to_string(values.size()) + " coefficients")
          .allowed("10");
    std::copy(values.begin(), values.end(), segment.coefficients[d].begin());
  }
  return segment;
}

}  // namespace

Json to_json(const survey::Mission& mission) {
  Json waypoints = Json::array(), views = Json::array(), trajectory = Json::array();
  for (const auto& w : mission.waypoints) waypoints.push(waypoint_json(w));
  for (const auto& v : mission.views) views.push(view_json(v));
  for (const auto& s : mission.trajectory) trajectory.push(segment_json(s));
  return Json::object(
      {{"schema_version", kMissionSchemaVersion},
       {"what", kWhat},
       {"name", mission.name},
       {"kind", survey::name_of(mission.kind)},
       {"frame", to_json(mission.origin)},
       {"camera", to_json(mission.camera)},
       {"limits",
        Json::object({{"max_speed_m_s", finite(mission.limits.max_speed_m_s, "max_speed_m_s")},
                      {"max_acceleration_m_s2", finite(mission.limits.max_acceleration_m_s2, "max_acceleration_m_s2")},
                      {"max_yaw_rate_deg_s", finite(mission.limits.max_yaw_rate_deg_s, "max_yaw_rate_deg_s")}})},
       {"waypoints", std::move(waypoints)},
       {"views", std::move(views)},
       {"trajectory", std::move(trajectory)},
       {"notes", Json(mission.notes)}});
}

survey::Mission mission_from_json(const Json& json, std::string_view name) {
  std::string where = "file";
  try {
    if (const auto version = json.at("schema_version").as_integer(); version != kMissionSchemaVersion)
      throw Error(ErrorCode::invalid_input, "unknown schema version")
          .found(std::to_string(version))
          .allowed(std::to_string(kMissionSchemaVersion));
    survey::Mission mission;
    mission.name = json.at("name").as_string();
    const auto kind = survey::mission_kind_from(json.at("kind").as_string());
    if (!kind)
      throw Error(ErrorCode::invalid_input, "unknown kind of mission")
          .found("'" + json.at("kind").as_string() + "'")
          .allowed("lawnmower, cylinder, gaps");
    mission.kind = *kind;
    where = "frame";
    mission.origin = origin_from_json(json.at("frame"));
    where = "camera";
    mission.camera = camera_from_json(json.at("camera"));
    where = "limits";
    const Json& limits = json.at("limits");
    mission.limits = {limits.at("max_speed_m_s").as_real(), limits.at("max_acceleration_m_s2").as_real(),
                      limits.at("max_yaw_rate_deg_s").as_real()};
    const auto each = [&where](const Json& list, const char* one, auto&& take) {
      std::size_t index = 0;
      for (const Json& record : list.as_array()) {
        where = std::string(one) + " " + std::to_string(++index);
        take(record);
      }
    };
    each(json.at("waypoints"), "waypoint", [&](const Json& j) { mission.waypoints.push_back(waypoint_from(j)); });
    each(json.at("views"), "view", [&](const Json& j) {
      mission.views.push_back(view_from(j, mission.camera.id));
      if (mission.views.size() > 1 && mission.views[mission.views.size() - 2].id >= mission.views.back().id)
        throw Error(ErrorCode::invalid_input, "ids of views do not ascend");
    });
    each(json.at("trajectory"), "segment", [&](const Json& j) { mission.trajectory.push_back(segment_from(j)); });
    where = "notes";
    mission.notes = text_list(json.at("notes"));
    return mission;
  } catch (Error& error) {
    error.default_file(name);
    error.in(where);
    throw;
  }
}

void write_mission(const std::filesystem::path& path, const survey::Mission& mission) {
  base::write_file(path, to_json(mission).dump() + "\n");
}

survey::Mission read_mission(const std::filesystem::path& path) {
  return mission_from_json(read_json(path), path.string());
}

bool is_mission_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string head(256, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, in.gcount())));
  return head.find(kWhat) != std::string::npos;
}

}  // namespace cairn::io
