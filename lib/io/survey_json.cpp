#include "io/survey_json.hpp"

#include <Eigen/LU>
#include <cmath>
#include <set>
#include <string>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "geodesy/local_frame.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;

constexpr double kOrthonormalTolerance = 1e-6;  // of R^T R - 1; text with seven digits passes

[[noreturn]] void unknown_name(std::string_view field, const std::string& value, std::string_view allowed) {
  throw Error(ErrorCode::invalid_input, "unknown " + std::string(field)).found("'" + value + "'").allowed(allowed);
}

survey::HeightType height_type_of(const Json& json) {
  const std::string& name = json.as_string();
  if (const auto type = survey::height_type_from(name)) return *type;
  unknown_name("height_type", name, "ellipsoidal, orthometric, relative_takeoff, unknown");
}

survey::Confidence confidence_of(const Json& json) {
  const std::string& name = json.as_string();
  for (const auto value : {survey::Confidence::declared, survey::Confidence::inferred, survey::Confidence::assumed})
    if (survey::name_of(value) == name) return value;
  unknown_name("confidence", name, "declared, inferred, assumed");
}

std::string text_or(const Json& json, std::string_view key, std::string fallback) {
  const Json* value = json.find(key);
  return value == nullptr || value->is_null() ? fallback : value->as_string();
}

Json rows(const geometry::Mat3& m) {
  Json::Array out;
  for (int r = 0; r < 3; ++r) out.push_back(Json(geometry::Vec3(m.row(r).transpose())));
  return out;
}

geometry::Mat3 matrix_of(const Json& json) {
  if (json.as_array().size() != 3)
    throw Error(ErrorCode::invalid_input, "matrix of the wrong size")
        .found(std::to_string(json.size()))
        .allowed("3 rows");
  geometry::Mat3 m;
  for (int r = 0; r < 3; ++r) m.row(r) = json.as_array()[static_cast<std::size_t>(r)].as_vec3().transpose();
  return m;
}

Json source_to_json(const survey::Source& source) {
  Json json = Json::object({{"kind", source.kind},
                            {"path", source.path},
                            {"convention", source.convention},
                            {"confidence", survey::name_of(source.confidence)},
                            {"crs", source.crs},
                            {"height_type", survey::name_of(source.height_type)}});
  if (source.T_world_source) json.set("T_world_source", to_json(*source.T_world_source));
  return json;
}

survey::Source source_from_json(const Json& json) {
  survey::Source source;
  source.kind = json.at("kind").as_string();
  source.path = json.at("path").as_string();
  source.convention = json.at("convention").as_string();
  source.confidence = confidence_of(json.at("confidence"));
  source.crs = text_or(json, "crs", "");
  if (const Json* type = json.find("height_type")) source.height_type = height_type_of(*type);
  if (const Json* transform = json.find("T_world_source"); transform != nullptr && !transform->is_null())
    source.T_world_source = similarity_from_json(*transform);
  return source;
}

}  // namespace

Json to_json(const survey::Camera& c) {
  return Json::object({{"id", c.id.value},
                       {"name", c.name},
                       {"model", survey::name_of(c.model)},
                       {"width_px", c.width_px},
                       {"height_px", c.height_px},
                       {"fx_px", c.fx_px},
                       {"fy_px", c.fy_px},
                       {"cx_px", c.cx_px},
                       {"cy_px", c.cy_px},
                       {"k1", c.k1},
                       {"k2", c.k2},
                       {"k3", c.k3},
                       {"k4", c.k4},
                       {"p1", c.p1},
                       {"p2", c.p2}});
}

survey::Camera camera_from_json(const Json& json) {
  survey::Camera c;
  c.id = survey::CameraId(json.at("id").as_integer());
  if (!c.id.valid())
    throw Error(ErrorCode::invalid_input, "camera id is negative")
        .found(std::to_string(c.id.value))
        .allowed("0 or more");
  c.name = text_or(json, "name", "");
  const std::string& model = json.at("model").as_string();
  const auto known = survey::camera_model_from(model);
  if (!known) unknown_name("camera model", model, "pinhole, radial, brown, fisheye");
  c.model = *known;
  c.width_px = json.at("width_px").as_integer();
  c.height_px = json.at("height_px").as_integer();
  c.fx_px = json.at("fx_px").as_real();
  c.fy_px = json.at("fy_px").as_real();
  c.cx_px = json.at("cx_px").as_real();
  c.cy_px = json.at("cy_px").as_real();
  const auto coefficient = [&](std::string_view name) {
    const Json* value = json.find(name);
    return value == nullptr ? 0.0 : value->as_real();
  };
  c.k1 = coefficient("k1");
  c.k2 = coefficient("k2");
  c.k3 = coefficient("k3");
  c.k4 = coefficient("k4");
  c.p1 = coefficient("p1");
  c.p2 = coefficient("p2");
  constexpr std::int64_t kMaxSide = 1'000'000;
  const std::string size = std::to_string(c.width_px) + " x " + std::to_string(c.height_px);
  if (c.width_px <= 0 || c.height_px <= 0 || c.width_px > kMaxSide || c.height_px > kMaxSide)
    throw Error(ErrorCode::invalid_input, "image size out of range").found(size).allowed("1 to 1000000 px a side");
  if (!(c.fx_px > 0.0) || !(c.fy_px > 0.0))
    throw Error(ErrorCode::invalid_input, "focal length is not positive")
        .found(base::to_text(c.fx_px) + ", " + base::to_text(c.fy_px))
        .allowed("more than 0 px");
  return c;
}

Json to_json(const geometry::Similarity& s) {
  return Json::object({{"scale", s.scale}, {"rotation", rows(s.rotation)}, {"translation_m", Json(s.translation)}});
}

geometry::Similarity similarity_from_json(const Json& json) {
  geometry::Similarity s;
  if (const Json* scale = json.find("scale")) s.scale = scale->as_real();
  if (!(s.scale > 0.0))
    throw Error(ErrorCode::invalid_input, "scale is not positive").found(base::to_text(s.scale)).allowed("more than 0");
  s.translation = json.at("translation_m").as_vec3();
  if (const Json* q = json.find("quaternion")) {
    const geometry::Quaternion quaternion{q->at("qw").as_real(), q->at("qx").as_real(), q->at("qy").as_real(),
                                          q->at("qz").as_real()};
    if (!(std::abs(quaternion.norm() - 1.0) < 1e-3))
      throw Error(ErrorCode::invalid_input, "quaternion is not of unit length")
          .found("|q| = " + base::to_text(quaternion.norm()))
          .allowed("1 within 0.001");
    s.rotation = geometry::rotation_matrix(quaternion);
    return s;
  }
  s.rotation = matrix_of(json.at("rotation"));
  const double off = (s.rotation.transpose() * s.rotation - geometry::Mat3::Identity()).cwiseAbs().maxCoeff();
  if (!(off < kOrthonormalTolerance) || s.rotation.determinant() < 0.0)
    throw Error(ErrorCode::invalid_input, "rotation is not a rotation matrix")
        .found("largest element of R^T R - 1: " + base::to_text(off) + ", determinant " +
               base::to_text(s.rotation.determinant()))
        .allowed("orthonormal, determinant +1")
        .hint("Give the scale apart from the rotation");
  return s;
}

Json to_json(const survey::Origin& origin) {
  return Json::object({{"latitude_deg", origin.position.latitude_deg},
                       {"longitude_deg", origin.position.longitude_deg},
                       {"height_m", origin.position.height_m},
                       {"height_type", survey::name_of(origin.height_type)},
                       {"geoid", origin.geoid}});
}

survey::Origin origin_from_json(const Json& json) {
  survey::Origin origin;
  origin.position = {json.at("latitude_deg").as_real(), json.at("longitude_deg").as_real(),
                     json.at("height_m").as_real()};
  origin.height_type = height_type_of(json.at("height_type"));
  origin.geoid = text_or(json, "geoid", "");
  const geodesy::LocalFrame checked(origin.position);  // refuses a position off the globe
  return origin;
}

void require_same_frame(const survey::Origin& found, const survey::Origin& expected, std::string_view name) {
  const auto text = [](const survey::Origin& o) {
    return base::to_text(o.position.latitude_deg) + ", " + base::to_text(o.position.longitude_deg) + ", " +
           base::to_text(o.position.height_m) + " m " + std::string(survey::name_of(o.height_type));
  };
  if (found.position == expected.position && found.height_type == expected.height_type && found.geoid == expected.geoid)
    return;
  throw Error(ErrorCode::crs_mismatch, "file is in another local frame than the survey")
      .file(name)
      .found("origin " + text(found))
      .allowed("origin " + text(expected))
      .hint("Use results of this survey");
}

Json to_json(const survey::Manifest& manifest) {
  Json cameras = Json::array(), sources = Json::array();
  for (const auto& camera : manifest.cameras) cameras.push(to_json(camera));
  for (const auto& source : manifest.sources) sources.push(source_to_json(source));
  return Json::object({{"schema_version", manifest.schema_version},
                       {"name", manifest.name},
                       {"origin", to_json(manifest.origin)},
                       {"time_base", base::name_of(manifest.time_base)},
                       {"cameras", std::move(cameras)},
                       {"sources", std::move(sources)},
                       {"notes", Json(manifest.notes)}});
}

survey::Manifest manifest_from_json(const Json& json, std::string_view name) {
  std::string where = "survey";
  try {
    survey::Manifest manifest;
    const std::int64_t version = json.at("schema_version").as_integer();
    if (version != kSurveySchemaVersion)
      throw Error(ErrorCode::invalid_input, "unknown schema version")
          .found(std::to_string(version))
          .allowed(std::to_string(kSurveySchemaVersion))
          .hint("Import the survey again with this version of cairn");
    manifest.schema_version = static_cast<int>(version);
    manifest.name = text_or(json, "name", "");
    where = "origin";
    manifest.origin = origin_from_json(json.at("origin"));
    where = "time_base";
    const std::string time_base = text_or(json, "time_base", "unknown");
    const auto known = base::time_base_from(time_base);
    if (!known) unknown_name("time_base", time_base, "utc, gps, boot, unknown");
    manifest.time_base = *known;
    std::set<std::int64_t> ids;
    for (const auto& item : json.at("cameras").as_array()) {
      where = "camera " + std::to_string(manifest.cameras.size() + 1) + " of the list";
      manifest.cameras.push_back(camera_from_json(item));
      if (!ids.insert(manifest.cameras.back().id.value).second)
        throw Error(ErrorCode::invalid_input, "camera id appears twice")
            .found(std::to_string(manifest.cameras.back().id.value));
    }
    if (const Json* sources = json.find("sources"))
      for (const auto& item : sources->as_array()) {
        where = "source " + std::to_string(manifest.sources.size() + 1) + " of the list";
        manifest.sources.push_back(source_from_json(item));
      }
    where = "notes";
    if (const Json* notes = json.find("notes"))
      for (const auto& note : notes->as_array()) manifest.notes.push_back(note.as_string());
    return manifest;
  } catch (Error& error) {
    error.default_file(name);
    error.in(where);
    throw;
  }
}

}  // namespace cairn::io
