#include "io/obstacles_json.hpp"

#include <utility>

#include "base/error.hpp"
#include "base/number_text.hpp"
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

std::size_t count_from(const Json& json, const char* name) {
  const std::int64_t value = json.as_integer();
  if (value < 0)
    throw base::Error(base::ErrorCode::invalid_input, std::string(name) + " is negative")
        .found(std::to_string(value))
        .allowed("0 or more");
  return static_cast<std::size_t>(value);
}

// A covariance has variances that are not negative and no correlation beyond 1; sizes are not negative.
void require_proper(const survey::Obstacle& o) {
  constexpr double kRounding = 1e-9;
  const auto& c = o.covariance;
  if (!(c(0, 0) >= 0.0) || !(c(1, 1) >= 0.0) || !(c(0, 1) * c(1, 0) <= c(0, 0) * c(1, 1) * (1.0 + kRounding)))
    throw base::Error(base::ErrorCode::invalid_input, "covariance_m2 is no covariance")
        .found("[" + base::to_text(c(0, 0)) + ", " + base::to_text(c(0, 1)) + "; " + base::to_text(c(1, 0)) + ", " +
               base::to_text(c(1, 1)) + "]")
        .allowed("finite, symmetric, positive semi-definite");
  for (const auto& [name, value] : {std::pair{"width_m", o.width_m}, std::pair{"height_m", o.height_m}})
    if (!(value >= 0.0))
      throw base::Error(base::ErrorCode::invalid_input, std::string(name) + " is negative")
          .found(base::to_text(value))
          .allowed("0 or more");
}

}  // namespace

Json to_json(const survey::Obstacle& o) {
  for (int i = 0; i < 4; ++i) finite(o.covariance.data()[i], "covariance_m2");
  Json json = Json::object({{"id", o.target.value},
                            {"class", o.object_class},
                            {"kind", survey::name_of(o.kind)},
                            {"position_m", vec3_to_json(o.position, "position_m")},
                            {"covariance_m2", matrix_to_json<2>(o.covariance)},
                            {"width_m", finite(o.width_m, "width_m")},
                            {"height_m", finite(o.height_m, "height_m")},
                            {"score", finite(o.score, "score")},
                            {"observations", o.observations},
                            {"misses", o.misses},
                            {"first_seen_ns", o.first_seen_ns},
                            {"last_seen_ns", o.last_seen_ns},
                            {"sigma_width_m", finite(o.sigma_width_m, "sigma_width_m")},
                            {"sigma_height_m", finite(o.sigma_height_m, "sigma_height_m")}});
  if (o.velocity) {
    for (int i = 0; i < 4; ++i) finite(o.velocity_covariance.data()[i], "velocity_covariance_m2_s2");
    json.set("velocity_m_s", Json(std::vector<double>{finite(o.velocity->x(), "velocity_m_s"),
                                                      finite(o.velocity->y(), "velocity_m_s")}));
    json.set("velocity_covariance_m2_s2", matrix_to_json<2>(o.velocity_covariance));
  }
  return json;
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
  o.observations = count_from(json.at("observations"), "observations");
  // Files of schema 1 may come without the history.
  if (const auto* misses = json.find("misses")) o.misses = count_from(*misses, "misses");
  if (const auto* seen = json.find("first_seen_ns")) o.first_seen_ns = seen->as_integer();
  if (const auto* seen = json.find("last_seen_ns")) o.last_seen_ns = seen->as_integer();
  if (const auto* sigma = json.find("sigma_width_m")) o.sigma_width_m = sigma->as_real();
  if (const auto* sigma = json.find("sigma_height_m")) o.sigma_height_m = sigma->as_real();
  if (const auto* velocity = json.find("velocity_m_s")) {
    if (velocity->size() != 2)
      throw base::Error(base::ErrorCode::invalid_input, "velocity_m_s is not two numbers")
          .found(std::to_string(velocity->size()))
          .allowed("2");
    o.velocity = geometry::Vec2(velocity->as_array()[0].as_real(), velocity->as_array()[1].as_real());
    o.velocity_covariance = matrix_from_json<2>(json.at("velocity_covariance_m2_s2"));
  }
  require_proper(o);
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
