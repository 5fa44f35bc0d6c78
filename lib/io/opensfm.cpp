#include "io/opensfm.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/json.hpp"

namespace cairn::io {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Vec2;
using geometry::Vec3;
using survey::Camera;
using survey::CameraModel;

Error wrong(std::string message) {
  return {ErrorCode::invalid_input, std::move(message)};
}

double real_or(const Json& object, std::string_view key, double fallback) {
  const Json* value = object.find(key);
  return value == nullptr || value->is_null() ? fallback : value->as_real();
}

double real_of(const Json& object, std::initializer_list<std::string_view> keys) {
  for (const auto key : keys)
    if (const Json* value = object.find(key)) return value->as_real();
  throw wrong("a camera lacks its focal length").allowed(std::string(*keys.begin()));
}

Camera camera_from(const std::string& name, const Json& json, std::int64_t id) {
  Camera camera;
  camera.id = survey::CameraId(id);
  camera.name = name;
  camera.width_px = json.at("width").as_integer();
  camera.height_px = json.at("height").as_integer();
  if (camera.width_px <= 0 || camera.height_px <= 0)
    throw wrong("a camera has no size")
        .record("camera " + name)
        .found(std::to_string(camera.width_px) + " x " + std::to_string(camera.height_px))
        .allowed("more than 0");
  const std::string& type = json.at("projection_type").as_string();
  if (type == "perspective" || type == "simple_radial" || type == "radial") camera.model = CameraModel::radial;
  else if (type == "brown") camera.model = CameraModel::brown;
  else if (type == "fisheye" || type == "fisheye_opencv") camera.model = CameraModel::fisheye;
  else
    throw wrong("unsupported camera model")
        .record("camera " + name)
        .found(type)
        .allowed("perspective, simple_radial, radial, brown, fisheye, fisheye_opencv");
  const auto longer = static_cast<double>(std::max(camera.width_px, camera.height_px));
  camera.fx_px = real_of(json, {"focal", "focal_x"}) * longer;
  camera.fy_px = real_of(json, {"focal", "focal_y"}) * longer;
  camera.cx_px = real_or(json, "c_x", 0.0) * longer + 0.5 * static_cast<double>(camera.width_px);
  camera.cy_px = real_or(json, "c_y", 0.0) * longer + 0.5 * static_cast<double>(camera.height_px);
  camera.k1 = real_or(json, "k1", 0.0);
  camera.k2 = real_or(json, "k2", 0.0);
  if (camera.model != CameraModel::radial) camera.k3 = real_or(json, "k3", 0.0);
  if (camera.model == CameraModel::fisheye) camera.k4 = real_or(json, "k4", 0.0);
  if (camera.model == CameraModel::brown) {
    camera.p1 = real_or(json, "p1", 0.0);
    camera.p2 = real_or(json, "p2", 0.0);
  }
  if (!(camera.fx_px > 0.0 && camera.fy_px > 0.0))
    throw wrong("a camera's focal length is not positive").record("camera " + name);
  return camera;
}

// World-to-camera angle-axis and translation, inverted.
geometry::RigidTransform pose_from(const Json& shot) {
  const Vec3 turn = shot.at("rotation").as_vec3(), t = shot.at("translation").as_vec3();
  if (!turn.allFinite() || !t.allFinite()) throw wrong("a pose is not finite");
  const double angle = turn.norm();
  const geometry::RigidTransform T_camera_world{
      angle > 0.0 ? geometry::axis_rotation(turn / angle, angle) : geometry::Mat3(geometry::Mat3::Identity()), t};
  return T_camera_world.inverse();
}

std::optional<geometry::Geodetic> reference_from(const Json& json) {
  return geometry::Geodetic{json.at("latitude").as_real(), json.at("longitude").as_real(),
                            json.at("altitude").as_real()};
}

std::int64_t id_from(std::string_view text) {
  std::int64_t id = 0;
  const auto end = text.data() + text.size();
  const auto [at, failed] = std::from_chars(text.data(), end, id);
  if (failed != std::errc() || at != end || id < 0)
    throw wrong("a point's id is not a number").found("'" + std::string(text) + "'").allowed("0, 1, 2, ...");
  return id;
}

void read_shots(const Json& json, const std::map<std::string, std::size_t>& cameras, OpensfmModel& model) {
  for (const auto& [name, shot] : json.as_object()) try {
      OpensfmShot result;
      result.image = name;
      const auto& camera = shot.at("camera").as_string();
      const auto known = cameras.find(camera);
      if (known == cameras.end()) throw wrong("a shot's camera is not in the file").found("'" + camera + "'");
      result.camera = known->second;
      result.T_world_camera = pose_from(shot);
      if (const Json* time = shot.find("capture_time"); time != nullptr && time->is_number() && time->as_real() > 0.0)
        result.capture_time_s = time->as_real();
      if (const Json* dop = shot.find("gps_dop"); dop != nullptr && dop->is_number() && dop->as_real() > 0.0)
        result.gps_dop_m = dop->as_real();
      model.shots.push_back(std::move(result));
    } catch (Error& error) {
      error.in("shot " + name);
      throw;
    }
  std::sort(model.shots.begin(), model.shots.end(),
            [](const OpensfmShot& a, const OpensfmShot& b) { return a.image < b.image; });
}

void read_points(const Json& json, OpensfmModel& model) {
  for (const auto& [name, point] : json.as_object()) {
    OpensfmPoint result;
    result.id = id_from(name);
    result.position = point.at("coordinates").as_vec3();
    model.points.push_back(std::move(result));
  }
  std::sort(model.points.begin(), model.points.end(),
            [](const OpensfmPoint& a, const OpensfmPoint& b) { return a.id < b.id; });
  const auto twice = std::adjacent_find(model.points.begin(), model.points.end(),
                                        [](const OpensfmPoint& a, const OpensfmPoint& b) { return a.id == b.id; });
  if (twice != model.points.end()) throw wrong("two points have one id").found(std::to_string(twice->id));
}

// Cells of a tab-separated row.
std::vector<std::string_view> cells_of(std::string_view row) {
  std::vector<std::string_view> cells;
  while (true) {
    const auto tab = row.find('\t');
    cells.push_back(row.substr(0, tab));
    if (tab == std::string_view::npos) return cells;
    row.remove_prefix(tab + 1);
  }
}

void read_tracks(std::string_view text, OpensfmModel& model) {
  std::map<std::string, std::size_t, std::less<>> shots;
  for (std::size_t i = 0; i < model.shots.size(); ++i) shots.emplace(model.shots[i].image, i);
  std::size_t line = 0, unknown_image = 0;
  constexpr std::size_t kTrack = 1, kX = 3, kY = 4;
  while (!text.empty()) {
    const auto end = text.find('\n');
    std::string_view row = base::trim(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    ++line;
    if (row.empty() || (line == 1 && row.starts_with("OPENSFM_TRACKS_VERSION"))) continue;
    const auto bad = [&](std::string message) {
      return wrong(std::move(message)).record("line " + std::to_string(line));
    };
    const auto cells = cells_of(row);
    if (cells.size() <= kY)
      throw bad("a track row has too few cells")
          .found(std::to_string(cells.size()))
          .allowed("image, track, feature, x, y, ... separated by tabs");
    const auto shot = shots.find(cells[0]);
    if (shot == shots.end()) {
      ++unknown_image;
      continue;
    }
    std::int64_t track = 0;
    try {
      track = id_from(cells[kTrack]);
    } catch (const Error&) {
      throw bad("a track's id is not a number").found("'" + std::string(cells[kTrack]) + "'");
    }
    const auto point = std::lower_bound(model.points.begin(), model.points.end(), track,
                                        [](const OpensfmPoint& p, std::int64_t wanted) { return p.id < wanted; });
    if (point == model.points.end() || point->id != track) continue;  // most tracks make no point
    const auto x = base::parse_real(cells[kX]), y = base::parse_real(cells[kY]);
    if (!x || !y || !std::isfinite(*x) || !std::isfinite(*y))
      throw bad("a track's place is not a number").found(std::string(cells[kX]) + ", " + std::string(cells[kY]));
    const auto& camera = model.cameras[model.shots[shot->second].camera];
    point->observations.push_back({shot->second, opensfm_pixel({*x, *y}, static_cast<double>(camera.width_px),
                                                               static_cast<double>(camera.height_px))});
  }
  if (unknown_image > 0)
    model.notes.push_back(std::to_string(unknown_image) +
                          " rows of the tracks are of images that the reconstruction does not hold.");
  for (auto& point : model.points) {
    auto& seen = point.observations;
    std::sort(seen.begin(), seen.end(), [](const auto& a, const auto& b) { return a.shot < b.shot; });
    const auto twice =
        std::adjacent_find(seen.begin(), seen.end(), [](const auto& a, const auto& b) { return a.shot == b.shot; });
    if (twice != seen.end())
      throw wrong("a track sees one image twice")
          .found("track " + std::to_string(point.id) + ", " + model.shots[twice->shot].image);
  }
}

}  // namespace

Vec2 opensfm_pixel(const Vec2& normalised, double width_px, double height_px) {
  const double longer = std::max(width_px, height_px);
  return {normalised.x() * longer + 0.5 * width_px, normalised.y() * longer + 0.5 * height_px};
}

OpensfmModel parse_opensfm(std::string_view reconstruction, std::string_view tracks, const fs::path& file,
                           const fs::path& tracks_file) {
  OpensfmModel model;
  try {
    const Json json = parse_json(reconstruction, file.string());
    if (!json.is_array() || json.size() == 0)
      throw wrong("not an OpenSfM reconstruction")
          .allowed("a list of reconstructions, each with cameras, shots, points");
    const auto& all = json.as_array();
    const auto taken = std::max_element(all.begin(), all.end(), [](const Json& a, const Json& b) {
      return a.at("shots").size() < b.at("shots").size();
    });
    for (auto it = all.begin(); it != all.end(); ++it)
      if (it != taken)
        for (const auto& [name, shot] : it->at("shots").as_object()) model.left_out.push_back(name);
    std::map<std::string, std::size_t> cameras;
    for (const auto& [name, camera] : taken->at("cameras").as_object()) {
      cameras.emplace(name, model.cameras.size());
      model.cameras.push_back(camera_from(name, camera, static_cast<std::int64_t>(model.cameras.size()) + 1));
    }
    read_shots(taken->at("shots"), cameras, model);
    if (const Json* points = taken->find("points")) read_points(*points, model);
    if (const Json* reference = taken->find("reference_lla")) model.reference = reference_from(*reference);
  } catch (Error& error) {
    error.default_file(file.string());
    throw;
  }
  try {
    if (!tracks.empty()) read_tracks(tracks, model);
  } catch (Error& error) {
    error.default_file(tracks_file.string());
    throw;
  }
  return model;
}

OpensfmModel read_opensfm(const fs::path& path, const fs::path& tracks) {
  fs::path file = path;
  std::error_code code;
  if (fs::is_directory(path, code)) {
    file = path / "reconstruction.json";
    if (!fs::exists(file, code) && fs::exists(path / "opensfm" / "reconstruction.json", code))
      file = path / "opensfm" / "reconstruction.json";
  }
  if (!fs::is_regular_file(file, code))
    throw Error(ErrorCode::not_found, "no reconstruction")
        .file(file.string())
        .hint("Name reconstruction.json, or the folder of an OpenSfM or OpenDroneMap project");
  fs::path tracks_file = tracks;
  if (tracks_file.empty() && fs::exists(file.parent_path() / "tracks.csv", code))
    tracks_file = file.parent_path() / "tracks.csv";
  const std::string text = base::read_file(file);
  const std::string tracks_text = tracks_file.empty() ? std::string() : base::read_file(tracks_file);
  auto model = parse_opensfm(text, tracks_text, file, tracks_file);
  const fs::path reference = file.parent_path() / "reference_lla.json";
  if (!model.reference && fs::exists(reference, code)) try {
      model.reference = reference_from(parse_json(base::read_file(reference), reference.string()));
    } catch (Error& error) {
      error.default_file(reference.string());
      throw;
    }
  return model;
}

}  // namespace cairn::io
