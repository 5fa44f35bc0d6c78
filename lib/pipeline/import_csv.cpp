#include "pipeline/import_csv.hpp"

#include <array>
#include <cmath>
#include <set>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "base/time.hpp"
#include "camera/dji_pose.hpp"
#include "geodesy/local_frame.hpp"
#include "io/csv.hpp"
#include "io/image.hpp"
#include "io/survey_folder.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;

constexpr double kQuaternionTolerance = 1e-3;  // of |q|
constexpr double kOriginStep = 1e4;            // origin to 1e-4 deg

constexpr std::string_view kNeeded =
    "a header row that names: image; x_m,y_m,z_m or latitude_deg,longitude_deg,height_m; qw,qx,qy,qz or "
    "yaw_deg,pitch_deg,roll_deg";

// A table without a header row often fails at its first line, which is data.
io::CsvReader open_table(const fs::path& path) {
  try {
    return io::CsvReader(path);
  } catch (Error& error) {
    if (error.code() != ErrorCode::invalid_input) throw;
    throw std::move(error).allowed(kNeeded);
  }
}

using Three = std::array<std::size_t, 3>;

// Columns under one of two spellings; empty where any is missing.
template <std::size_t N>
std::optional<std::array<std::size_t, N>> columns(const io::CsvReader& table,
                                                  const std::array<std::string_view, N>& names,
                                                  const std::array<std::string_view, N>& other) {
  std::array<std::size_t, N> found{};
  for (std::size_t i = 0; i < N; ++i) {
    auto index = table.find(names[i]);
    if (!index) index = table.find(other[i]);
    if (!index) return std::nullopt;
    found[i] = *index;
  }
  return found;
}

struct Layout {
  std::size_t image = 0;
  std::optional<Three> local, geodetic, angles;
  std::optional<std::array<std::size_t, 4>> quaternion;
};

Layout layout_of(const io::CsvReader& table, const ImportCsvInputs& in) {
  Layout layout;
  layout.local = columns<3>(table, {"x_m", "y_m", "z_m"}, {"x", "y", "z"});
  layout.geodetic = columns<3>(table, {"latitude_deg", "longitude_deg", "height_m"}, {"lat", "lon", "height"});
  layout.angles = columns<3>(table, {"yaw_deg", "pitch_deg", "roll_deg"}, {"yaw", "pitch", "roll"});
  layout.quaternion = columns<4>(table, {"qw", "qx", "qy", "qz"}, {"qw", "qx", "qy", "qz"});
  const auto image = table.find("image");
  if (!image || (!layout.local && !layout.geodetic) || (!layout.angles && !layout.quaternion)) {
    std::string there;
    for (const auto& name : table.header()) there += (there.empty() ? "" : ",") + name;
    throw Error(ErrorCode::invalid_input, "columns are missing, or have no names")
        .file(in.table.string())
        .record("header")
        .found("'" + there.substr(0, 200) + "'")
        .allowed(kNeeded);
  }
  layout.image = *image;
  if (layout.local && layout.geodetic)
    throw Error(ErrorCode::invalid_input, "two positions in one table")
        .file(in.table.string())
        .record("header")
        .allowed(kNeeded);
  if (layout.angles && layout.quaternion)
    throw Error(ErrorCode::invalid_input, "two rotations in one table")
        .file(in.table.string())
        .record("header")
        .allowed(kNeeded);
  if (layout.quaternion && in.pose != "camera-to-world" && in.pose != "world-to-camera")
    throw Error(ErrorCode::invalid_argument, "the direction of the poses is not declared")
        .found("--pose '" + in.pose + "'")
        .allowed("camera-to-world, world-to-camera")
        .hint("Add --pose");
  if (layout.angles && in.angles != "gimbal" && in.angles != "nadir-body")
    throw Error(ErrorCode::invalid_argument, "the convention of the angles is not declared")
        .found("--angles '" + in.angles + "'")
        .allowed("gimbal, nadir-body")
        .hint("Add --angles");
  if (!in.common.height_type)
    throw Error(ErrorCode::invalid_argument, "heights always name their datum").hint("Add --height-type");
  if (layout.local && !in.common.origin)
    throw Error(ErrorCode::invalid_argument, "local coordinates need an origin").hint("Add --origin LAT,LON,HEIGHT");
  return layout;
}

geometry::Geodetic geodetic_of(const io::CsvReader& table, const Three& c) {
  const geometry::Geodetic g{table.real(c[0]), table.real(c[1]), table.real(c[2])};
  if (!(std::abs(g.latitude_deg) <= 90.0))
    throw table.error(c[0], "latitude out of range").allowed("-90 to 90").hint("Are these metres of a projected CRS?");
  if (!(std::abs(g.longitude_deg) <= 180.0))
    throw table.error(c[1], "longitude out of range")
        .allowed("-180 to 180")
        .hint("Are these metres of a projected CRS?");
  if (!(std::abs(g.height_m) <= 20000.0)) throw table.error(c[2], "height out of range").allowed("-20000 to 20000");
  return g;
}

geometry::Mat3 rotation_of(const io::CsvReader& table, const Layout& layout, const ImportCsvInputs& in) {
  if (layout.angles) {
    const auto& c = *layout.angles;
    return camera::enu_from_camera({base::Angle::from_deg(table.real(c[0])), base::Angle::from_deg(table.real(c[1])),
                                    base::Angle::from_deg(table.real(c[2]))},
                                   in.angles == "gimbal" ? camera::CameraMount::forward : camera::CameraMount::nadir);
  }
  const auto& c = *layout.quaternion;
  const geometry::Quaternion q{table.real(c[0]), table.real(c[1]), table.real(c[2]), table.real(c[3])};
  if (!(std::abs(q.norm() - 1.0) <= kQuaternionTolerance))
    throw table.error("quaternion is not of unit length")
        .found("|q| = " + base::to_text(q.norm()))
        .allowed("1 within " + base::to_text(kQuaternionTolerance))
        .hint("Check the order of the columns qw, qx, qy, qz");
  return geometry::rotation_matrix(q);
}

std::string convention_of(const Layout& layout, const ImportCsvInputs& in) {
  std::string text = layout.local ? "Positions in the local east-north-up frame about the given origin; "
                                  : "Positions as WGS84 latitude, longitude and height; ";
  if (layout.quaternion) return text + "Hamilton quaternions qw, qx, qy, qz, " + in.pose + ".";
  return text + "yaw, pitch, roll in degrees against north-east-down in the order ZYX, of " +
         (in.angles == "gimbal" ? "a camera that looks along the body's forward axis."
                                : "a body with the camera fixed below, image top forward.");
}

void require_size(const fs::path& file, const survey::Camera& camera) {
  const io::ImageHeader header = io::read_image_header(file);
  if (header.width_px != camera.width_px || header.height_px != camera.height_px)
    throw Error(ErrorCode::failed_precondition, "image does not have the size of the camera")
        .file(file.string())
        .found(std::to_string(header.width_px) + " x " + std::to_string(header.height_px) + " px")
        .allowed(std::to_string(camera.width_px) + " x " + std::to_string(camera.height_px) + " px")
        .hint("Correct --camera: its parameters are for the image files' pixels");
}

}  // namespace

Outcome import_csv(const ImportCsvInputs& in, const fs::path& out, base::RunContext& ctx) {
  const auto time_base = base::time_base_from(in.time_base);
  if (!time_base)
    throw Error(ErrorCode::invalid_argument, "unknown time base")
        .found("'" + in.time_base + "'")
        .allowed("utc, gps, boot, unknown");
  if (in.camera.empty())
    throw Error(ErrorCode::invalid_argument, "a table of frames does not say which camera took them")
        .hint("Add --camera");
  const survey::Camera camera = parse_camera(in.camera);
  io::CsvReader table = open_table(in.table);
  const Layout layout = layout_of(table, in);
  const auto frame_id = table.find("frame_id"), time = table.find("time_ns"), sigma_xy = table.find("sigma_xy_m"),
             sigma_z = table.find("sigma_z_m"), sigma_rot = table.find("sigma_rot_deg");

  Imported imported;
  survey::Survey& survey = imported.survey;
  survey.manifest.cameras = {camera};
  survey.manifest.time_base = *time_base;
  std::vector<geometry::Geodetic> positions;
  std::set<std::int64_t> seen;
  const auto sigma = [&](const std::optional<std::size_t>& column) {
    const auto value = column ? table.optional_real(*column) : std::nullopt;
    if (value && *value < 0.0) throw table.error(*column, "standard deviation is negative").allowed("0 or more");
    return value.value_or(0.0);
  };
  while (table.next()) {
    survey::Frame frame;
    frame.camera = camera.id;
    if (frame_id) {
      frame.id = survey::FrameId(table.integer(*frame_id, 0, INT64_MAX));
      if (!seen.insert(frame.id.value).second) throw table.error(*frame_id, "id appears twice");
    }
    if (time && !base::trim(table.text(*time)).empty()) frame.time_ns = table.integer(*time);
    frame.sigma_xy_m = sigma(sigma_xy);
    frame.sigma_z_m = sigma(sigma_z);
    frame.sigma_rot_deg = sigma(sigma_rot);
    const geometry::Mat3 rotation = rotation_of(table, layout, in);
    const bool inverted = layout.quaternion && in.pose == "world-to-camera";
    frame.T_world_camera.rotation = inverted ? geometry::Mat3(rotation.transpose()) : rotation;
    if (layout.geodetic) {
      positions.push_back(geodetic_of(table, *layout.geodetic));
    } else {
      const geometry::Vec3 p(table.real((*layout.local)[0]), table.real((*layout.local)[1]),
                             table.real((*layout.local)[2]));
      frame.T_world_camera.translation = inverted ? geometry::Vec3(-(rotation.transpose() * p)) : p;
    }
    const std::string name(base::trim(table.required(layout.image)));
    imported.image_names.push_back(name);
    imported.image_files.push_back(in.images.empty() ? fs::path() : in.images / name);
    if (in.images.empty()) frame.image = name;
    else require_size(imported.image_files.back(), camera);
    survey.frames.push_back(std::move(frame));
  }
  if (!frame_id) {
    const auto ids = frame_ids_for(imported.image_names);
    for (std::size_t i = 0; i < ids.size(); ++i) survey.frames[i].id = ids[i];
  }
  auto& origin = survey.manifest.origin;
  origin.height_type = *in.common.height_type;
  if (in.common.origin) origin.position = *in.common.origin;
  else if (!positions.empty())
    origin.position = {std::round(positions[0].latitude_deg * kOriginStep) / kOriginStep,
                       std::round(positions[0].longitude_deg * kOriginStep) / kOriginStep, 0.0};
  if (!positions.empty()) {
    const geodesy::LocalFrame local(origin.position);
    for (std::size_t i = 0; i < positions.size(); ++i)
      survey.frames[i].T_world_camera.translation = local.to_local(positions[i]);
  }
  survey::Source poses;
  poses.kind = "poses";
  poses.path = io::file_reference(in.table, in.common.survey_folder);
  poses.convention = convention_of(layout, in);
  poses.crs = layout.local ? "local" : "EPSG:4326";
  poses.height_type = origin.height_type;
  survey.manifest.sources.push_back(std::move(poses));
  if (!in.images.empty()) {
    survey::Source images;
    images.kind = "images";
    images.path = io::file_reference(in.images, in.common.survey_folder);
    images.convention =
        "Raw pixels, no EXIF rotation applied, first pixel's centre at (0.5, 0.5); intrinsics as given.";
    survey.manifest.sources.push_back(std::move(images));
  }
  return finish_import(std::move(imported), in.common, 1.0, out, ctx);
}

}  // namespace cairn::pipeline
