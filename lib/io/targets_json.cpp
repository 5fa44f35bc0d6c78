#include "io/targets_json.hpp"

#include <utility>

#include "io/records_json.hpp"

namespace cairn::io {
namespace {

template <typename Id>
Json id_list(const std::vector<Id>& ids) {
  Json::Array out;
  for (const auto id : ids) out.emplace_back(id.value);
  return Json(std::move(out));
}

template <typename Id>
std::vector<Id> ids_from(const Json& json) {
  std::vector<Id> out;
  for (const auto& id : json.as_array()) out.emplace_back(id.as_integer());
  return out;
}

Json cylinder_to_json(const geometry::VerticalCylinder& c) {
  return Json::object({{"axis_m", Json(Json::Array{finite(c.axis.x(), "axis_m"), finite(c.axis.y(), "axis_m")})},
                       {"bottom_m", finite(c.bottom, "bottom_m")},
                       {"top_m", finite(c.top, "top_m")},
                       {"radius_m", finite(c.radius, "radius_m")}});
}

geometry::VerticalCylinder cylinder_from_json(const Json& json) {
  geometry::VerticalCylinder c;
  const auto axis = real_list(json.at("axis_m"));
  if (axis.size() != 2)
    throw base::Error(base::ErrorCode::invalid_input, "axis_m of the wrong length").allowed("[east, north]");
  c.axis = {axis[0], axis[1]};
  c.bottom = json.at("bottom_m").as_real();
  c.top = json.at("top_m").as_real();
  c.radius = json.at("radius_m").as_real();
  if (!(c.bottom <= c.top) || !(c.radius >= 0.0))
    throw base::Error(base::ErrorCode::invalid_input, "cylinder is inside out")
        .allowed("bottom_m <= top_m, radius_m >= 0");
  return c;
}

survey::TargetState state_from_json(const Json& json) {
  const std::string& state = json.at("state").as_string();
  const auto known = survey::target_state_from(state);
  if (!known)
    throw base::Error(base::ErrorCode::invalid_input, "unknown state")
        .found("'" + state + "'")
        .allowed("generated, converging, converged, mapped, deregistered");
  return *known;
}

Json refined_to_json(const survey::RefinedBody& r) {
  for (int i = 0; i < 9; ++i) finite(r.covariance.data()[i], "refined.covariance_m2");
  return Json::object({{"centre_m", vec3_to_json(r.centre, "refined.centre_m")},
                       {"covariance_m2", matrix_to_json<3>(r.covariance)},
                       {"cylinder", cylinder_to_json(r.cylinder)},
                       {"semi_axes_m", vec3_to_json(r.semi_axes_m, "refined.semi_axes_m")},
                       {"azimuth_deg", finite(r.azimuth_deg, "refined.azimuth_deg")},
                       {"rms_px", finite(r.rms_px, "refined.rms_px")},
                       {"boxes", r.boxes},
                       {"rejected_boxes", r.rejected_boxes}});
}

std::size_t count_from_json(const Json& json, const char* member) {
  const std::int64_t count = json.at(member).as_integer();
  if (count < 0)
    throw base::Error(base::ErrorCode::invalid_input, std::string(member) + " is negative")
        .found(std::to_string(count))
        .allowed("0 or more");
  return static_cast<std::size_t>(count);
}

survey::RefinedBody refined_from_json(const Json& json) {
  survey::RefinedBody r;
  r.centre = json.at("centre_m").as_vec3();
  r.covariance = matrix_from_json<3>(json.at("covariance_m2"));
  r.cylinder = cylinder_from_json(json.at("cylinder"));
  r.semi_axes_m = json.at("semi_axes_m").as_vec3();
  r.azimuth_deg = json.at("azimuth_deg").as_real();
  r.rms_px = json.at("rms_px").as_real();
  r.boxes = count_from_json(json, "boxes");
  r.rejected_boxes = count_from_json(json, "rejected_boxes");
  return r;
}

}  // namespace

const survey::Target* TargetsFile::find(survey::TargetId id) const {
  for (const auto& target : targets)
    if (target.id == id) return &target;
  return nullptr;
}

Json to_json(const survey::Target& t) {
  for (int i = 0; i < 9; ++i) finite(t.covariance.data()[i], "covariance_m2");
  Json history = Json::array();
  for (const auto& entry : t.history)
    history.push(Json::object({{"state", survey::name_of(entry.state)}, {"frame", entry.frame.value}}));
  return Json::object({{"id", t.id.value},
                       {"class", t.object_class},
                       {"state", survey::name_of(t.state)},
                       {"centre_m", vec3_to_json(t.centre, "centre_m")},
                       {"covariance_m2", matrix_to_json<3>(t.covariance)},
                       {"mean_score", finite(t.mean_score, "mean_score")},
                       {"detections", id_list(t.detections)},
                       {"keyframes", id_list(t.keyframes)},
                       {"bcylinder", t.bcylinder ? cylinder_to_json(*t.bcylinder) : Json()},
                       {"entropy_nats", finite_list(t.entropy_nats, "entropy_nats")},
                       {"divergence", finite_list(t.divergence, "divergence")},
                       {"history", std::move(history)},
                       {"refined", t.refined ? refined_to_json(*t.refined) : Json()},
                       {"reasons", Json(t.reasons)}});
}

survey::Target target_from_json(const Json& json) {
  survey::Target t;
  t.id = survey::TargetId(json.at("id").as_integer());
  t.object_class = json.at("class").as_string();
  t.state = state_from_json(json);
  t.centre = json.at("centre_m").as_vec3();
  t.covariance = matrix_from_json<3>(json.at("covariance_m2"));
  t.mean_score = json.at("mean_score").as_real();
  t.detections = ids_from<survey::DetectionId>(json.at("detections"));
  t.keyframes = ids_from<survey::FrameId>(json.at("keyframes"));
  if (const Json* cylinder = json.find("bcylinder"); cylinder != nullptr && !cylinder->is_null())
    t.bcylinder = cylinder_from_json(*cylinder);
  t.entropy_nats = real_list(json.at("entropy_nats"));
  t.divergence = real_list(json.at("divergence"));
  t.reasons = text_list(json.at("reasons"));
  if (const Json* history = json.find("history"))
    for (const auto& entry : history->as_array())
      t.history.push_back({state_from_json(entry), survey::FrameId(entry.at("frame").as_integer())});
  if (const Json* refined = json.find("refined"); refined != nullptr && !refined->is_null())
    t.refined = refined_from_json(*refined);
  return t;
}

void write_targets(const std::filesystem::path& path, const TargetsFile& file) {
  Json list = Json::array();
  for (const auto& target : file.targets) list.push(to_json(target));
  write_records(path, file.frame, "targets", std::move(list));
}

TargetsFile read_targets(const std::filesystem::path& path) {
  TargetsFile file;
  UniqueIds ids;
  file.frame = read_records(path, "targets", "target", [&](const Json& json) {
    file.targets.push_back(target_from_json(json));
    ids.add(file.targets.back().id.value);
  });
  return file;
}

}  // namespace cairn::io
