#include "io/obstacles_json.hpp"

#include <utility>

#include "io/records_json.hpp"

namespace cairn::io {
namespace {

survey::ObstacleKind kind_of(const std::string& name) {
  using survey::ObstacleKind;
  for (const auto kind : {ObstacleKind::obstacle, ObstacleKind::ignored, ObstacleKind::vehicle})
    if (survey::name_of(kind) == name) return kind;
  throw base::Error(base::ErrorCode::invalid_input, "unknown kind of obstacle")
      .found("'" + name + "'")
      .allowed("obstacle, ignored, vehicle");
}

}  // namespace

Json to_json(const survey::Obstacle& o) {
  for (int i = 0; i < 4; ++i) finite(o.covariance.data()[i], "covariance_m2");
  return Json::object({{"id", o.target.value},
                       {"class", o.object_class},
                       {"kind", survey::name_of(o.kind)},
                       {"position_m", vec3_to_json(o.position, "position_m")},
                       {"covariance_m2", matrix_to_json<2>(o.covariance)},
                       {"width_m", finite(o.width_m, "width_m")},
                       {"height_m", finite(o.height_m, "height_m")},
                       {"score", finite(o.score, "score")},
                       {"observations", o.observations}});
}

survey::Obstacle obstacle_from_json(const Json& json) {
  survey::Obstacle o;
  o.target = survey::TargetId(json.at("id").as_integer());
  o.object_class = json.at("class").as_string();
  o.kind = kind_of(json.at("kind").as_string());
  o.position = json.at("position_m").as_vec3();
  o.covariance = matrix_from_json<2>(json.at("covariance_m2"));
  o.width_m = json.at("width_m").as_real();
  o.height_m = json.at("height_m").as_real();
  o.score = json.at("score").as_real();
  const std::int64_t observations = json.at("observations").as_integer();
  if (observations < 0)
    throw base::Error(base::ErrorCode::invalid_input, "observations is negative")
        .found(std::to_string(observations))
        .allowed("0 or more");
  o.observations = static_cast<std::size_t>(observations);
  return o;
}

void write_obstacles(const std::filesystem::path& path, const ObstaclesFile& file) {
  Json list = Json::array();
  for (const auto& obstacle : file.obstacles) list.push(to_json(obstacle));
  write_records(path, file.frame, "obstacles", std::move(list));
}

ObstaclesFile read_obstacles(const std::filesystem::path& path) {
  ObstaclesFile file;
  UniqueIds ids;
  file.frame = read_records(path, "obstacles", "obstacle", [&](const Json& json) {
    file.obstacles.push_back(obstacle_from_json(json));
    ids.add(file.obstacles.back().target.value);
  });
  return file;
}

}  // namespace cairn::io
