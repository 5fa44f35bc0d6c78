#include "pipeline/import_dji.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "camera/dji_pose.hpp"
#include "geodesy/crs.hpp"
#include "geodesy/local_frame.hpp"
#include "io/survey_folder.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Angle;
using base::Error;
using base::ErrorCode;

constexpr std::int64_t kRtkSingle = 16;  // RtkFlag from here on: heights are ellipsoidal
constexpr double kOriginStep = 1e4;      // origin to 1e-4 deg

struct Photo {
  fs::path file;
  io::ImageMetadata metadata;
  geometry::Geodetic position;  // height still to be found
  camera::GimbalAngles angles;
  bool gimbal_yaw = true;
};

enum class HeightSource { takeoff, rtk, relative };

// Position and attitude, or why there is none.
std::optional<base::Reject> read_pose(Photo& photo) {
  const auto& m = photo.metadata;
  const std::string record = "frame " + photo.file.filename().string();
  const bool from_xmp = m.dji.latitude_deg && m.dji.longitude_deg;
  if (!from_xmp && !m.latitude_deg) return base::Reject{record, "no_position", "the image has no GPS position"};
  photo.position = from_xmp ? geometry::Geodetic{*m.dji.latitude_deg, *m.dji.longitude_deg, 0.0}
                            : geometry::Geodetic{*m.latitude_deg, *m.longitude_deg, 0.0};
  photo.gimbal_yaw = m.dji.gimbal_yaw_deg.has_value();
  const auto yaw = photo.gimbal_yaw ? m.dji.gimbal_yaw_deg : m.dji.flight_yaw_deg;
  if (!yaw || !m.dji.gimbal_pitch_deg)
    return base::Reject{record, "no_attitude", "the image has no gimbal yaw and pitch (XMP drone-dji)"};
  photo.angles = {Angle::from_deg(*yaw), Angle::from_deg(*m.dji.gimbal_pitch_deg),
                  Angle::from_deg(m.dji.gimbal_roll_deg.value_or(0.0))};
  return std::nullopt;
}

bool has_rtk_height(const io::ImageMetadata& m) {
  const bool type_agrees = m.dji.altitude_type.empty() || m.dji.altitude_type == "RtkAlt";
  return m.dji.rtk_flag.value_or(0) >= kRtkSingle && m.dji.absolute_altitude_m && type_agrees;
}

HeightSource height_source(const ImportDjiInputs& in, const std::vector<Photo>& photos) {
  if (in.takeoff_height_m) return HeightSource::takeoff;
  const bool rtk = std::all_of(photos.begin(), photos.end(), [](const Photo& p) { return has_rtk_height(p.metadata); });
  return rtk ? HeightSource::rtk : HeightSource::relative;
}

// The origin's height type that goes with the frames' heights.
survey::HeightType height_type_of(HeightSource source) {
  return source == HeightSource::relative ? survey::HeightType::relative_takeoff : survey::HeightType::ellipsoidal;
}

survey::Origin origin_of(const ImportDjiInputs& in, HeightSource source, const std::vector<Photo>& photos,
                         double takeoff_ellipsoidal) {
  const survey::HeightType type = height_type_of(source);
  if (in.common.origin && !in.common.height_type)
    throw Error(ErrorCode::invalid_argument, "heights always name their datum")
        .hint("Add --height-type " + std::string(survey::name_of(type)) + " to --origin");
  if (in.common.height_type && *in.common.height_type != type)
    throw Error(ErrorCode::crs_mismatch, "the frames' heights are of another datum than --height-type")
        .found(survey::name_of(*in.common.height_type))
        .allowed(survey::name_of(type))
        .hint(type == survey::HeightType::relative_takeoff ? "Give --takeoff-height, or --height-type relative_takeoff"
                                                           : "Leave --height-type out, or give ellipsoidal");
  if (in.common.origin) return {*in.common.origin, type, {}};
  const auto& first = photos.front();
  double height = 0.0;
  if (source == HeightSource::takeoff) height = takeoff_ellipsoidal;
  if (source == HeightSource::rtk) height = std::round(*first.metadata.dji.absolute_altitude_m);
  return {{std::round(first.position.latitude_deg * kOriginStep) / kOriginStep,
           std::round(first.position.longitude_deg * kOriginStep) / kOriginStep, height},
          type,
          {}};
}

std::string height_sentence(const ImportDjiInputs& in, HeightSource source) {
  switch (source) {
    case HeightSource::takeoff:
      return "height = take-off height " + base::to_text(*in.takeoff_height_m) + " m (" + in.takeoff_datum +
             (in.takeoff_datum == "egm96" ? ", converted to ellipsoidal" : "") + ") + RelativeAltitude";
    case HeightSource::rtk: return "height = AbsoluteAltitude of RTK fixes, ellipsoidal";
    case HeightSource::relative: break;
  }
  return "height = RelativeAltitude above the take-off point, whose own height is not known";
}

// Cameras by what makes them different; adds one where it is new.
class Cameras {
 public:
  explicit Cameras(survey::Manifest& manifest) : manifest_(manifest) {}

  survey::CameraId id_of(survey::Camera camera, const io::ImageMetadata& m, bool turned) {
    camera.name = m.make + " " + m.model;
    if (turned) {
      survey::Camera half = camera::turned_half(camera);
      if (!(half == camera)) half.name += ", turned by 180 degrees";
      camera = half;
    }
    for (const auto& known : manifest_.cameras) {
      camera.id = known.id;
      if (camera == known) return known.id;
    }
    camera.id = survey::CameraId(static_cast<std::int64_t>(manifest_.cameras.size()) + 1);
    manifest_.cameras.push_back(camera);
    return camera.id;
  }

 private:
  survey::Manifest& manifest_;
};

// Photographs whose software is not the one most have went through another program, which may have
// turned the pixels without touching the attitude.
void note_edited(const std::vector<Photo>& photos, survey::Manifest& manifest) {
  std::map<std::string, std::size_t> counts;
  for (const auto& photo : photos) ++counts[photo.metadata.software];
  const auto most =
      std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  for (const auto& [software, count] : counts) {
    if (software == most->first) continue;
    std::string names;
    for (const auto& photo : photos)
      if (photo.metadata.software == software) names += (names.empty() ? "" : ", ") + photo.file.stem().string();
    manifest.notes.push_back(
        std::to_string(count) + " photographs were written by '" + software + "', the others by '" + most->first +
        "' (" + names +
        "): their pixels may have been turned since the flight. cairn check compares them with their "
        "poses; --rotate corrects them.");
  }
}

void note_oddities(const std::vector<Photo>& photos, survey::Manifest& manifest) {
  std::size_t oriented = 0, reversed = 0;
  for (const auto& photo : photos) {
    if (photo.metadata.orientation != 1) ++oriented;
    if (photo.metadata.dji.camera_reversed) ++reversed;
  }
  if (oriented > 0)
    manifest.notes.push_back(
        std::to_string(oriented) +
        " photographs carry an EXIF orientation; poses and boxes are for the raw, un-rotated pixels.");
  if (reversed > 0)
    manifest.notes.push_back(
        std::to_string(reversed) +
        " photographs were taken with the camera reversed (CamReverse); the gimbal angles were used as "
        "they are.");
  note_edited(photos, manifest);
}

void require_size(const Photo& photo, const survey::Camera& camera) {
  const auto& size = photo.metadata.size;
  if (size.width_px != camera.width_px || size.height_px != camera.height_px)
    throw Error(ErrorCode::failed_precondition, "image does not have the size of the camera")
        .file(photo.file.string())
        .found(std::to_string(size.width_px) + " x " + std::to_string(size.height_px) + " px")
        .allowed(std::to_string(camera.width_px) + " x " + std::to_string(camera.height_px) + " px")
        .hint("Correct --camera: its parameters are for the image files' pixels");
}

void set_sigmas(const io::DjiMetadata& d, survey::Frame& frame) {
  const bool rtk = d.rtk_flag.value_or(0) >= kRtkSingle;
  frame.sigma_xy_m =
      rtk && d.rtk_std_lon_m && d.rtk_std_lat_m ? std::max(*d.rtk_std_lon_m, *d.rtk_std_lat_m) : kGnssSigmaXyM;
  frame.sigma_z_m = rtk && d.rtk_std_hgt_m ? *d.rtk_std_hgt_m : kBarometerSigmaZM;
  frame.sigma_rot_deg = kGimbalSigmaDeg;
}

}  // namespace

std::vector<bool> stems_named(const std::string& list, const std::vector<std::string>& stems) {
  std::vector<bool> named(stems.size(), false);
  std::string_view rest = list;
  while (!rest.empty()) {
    const auto comma = rest.find(',');
    const std::string_view item = base::trim(rest.substr(0, comma));
    rest.remove_prefix(comma == std::string_view::npos ? rest.size() : comma + 1);
    bool any = false;
    // A stem may itself hold a hyphen, so the whole item comes first.
    for (std::size_t i = 0; i < stems.size(); ++i)
      if (stems[i] == item) named[i] = any = true;
    for (auto hyphen = item.find('-'); !any && hyphen != std::string_view::npos; hyphen = item.find('-', hyphen + 1)) {
      const std::string_view from = item.substr(0, hyphen), to = item.substr(hyphen + 1);
      if (std::find(stems.begin(), stems.end(), from) == stems.end() ||
          std::find(stems.begin(), stems.end(), to) == stems.end())
        continue;
      for (std::size_t i = 0; i < stems.size(); ++i)
        if (stems[i] >= from && stems[i] <= to) named[i] = any = true;
    }
    if (!any)
      throw Error(ErrorCode::invalid_argument, "--rotate names no image")
          .found("'" + std::string(item) + "'")
          .allowed("names without extension, or ranges FIRST-LAST of such names, separated by commas")
          .hint("For example DJI_0024-DJI_0029");
  }
  return named;
}

Outcome import_dji(const ImportDjiInputs& in, const fs::path& out, base::RunContext& ctx) {
  if (in.takeoff_datum != "ellipsoidal" && in.takeoff_datum != "egm96")
    throw Error(ErrorCode::invalid_argument, "unknown take-off datum")
        .found("'" + in.takeoff_datum + "'")
        .allowed("ellipsoidal, egm96");
  Imported imported;
  survey::Survey& survey = imported.survey;
  const auto reject = [&](base::Reject why) {
    if (in.common.strict)
      throw Error(ErrorCode::invalid_input, why.message)
          .file(in.images.string())
          .record(why.record)
          .hint("Leave the image out, or import without --strict");
    imported.rejects.push_back(std::move(why));
  };

  const auto files = list_images(in.images);
  std::vector<Photo> photos;
  for (std::size_t i = 0; i < files.size(); ++i) {
    ctx.check_stop();
    ctx.progress("images", i, files.size());
    Photo photo{files[i], io::read_image_metadata(files[i]), {}, {}, true};
    if (auto why = read_pose(photo)) reject(std::move(*why));
    else photos.push_back(std::move(photo));
  }
  ctx.progress("images", files.size(), files.size());
  HeightSource heights = height_source(in, photos);
  if (heights != HeightSource::rtk)
    std::erase_if(photos, [&](const Photo& photo) {
      if (photo.metadata.dji.relative_altitude_m) return false;
      reject({"frame " + photo.file.filename().string(), "no_height",
              "the image has no RelativeAltitude (XMP drone-dji)"});
      return true;
    });
  std::optional<survey::Camera> given_camera;
  if (!in.camera.empty()) given_camera = parse_camera(in.camera);
  bool from_dewarp = false;
  std::erase_if(photos, [&](const Photo& photo) {
    if (given_camera) {
      require_size(photo, *given_camera);
      return false;
    }
    if (dji_camera(photo.metadata, from_dewarp)) return false;
    reject({"frame " + photo.file.filename().string(), "no_focal_length",
            "the image has neither DewarpData nor a 35 mm equivalent focal length"});
    return true;
  });
  if (photos.empty())
    throw Error(ErrorCode::invalid_input, "no photograph has a pose")
        .file(in.images.string())
        .found(imported.rejects.empty() ? std::string("no photographs") : imported.rejects.front().message)
        .allowed("photographs of a DJI aircraft with GPS and XMP drone-dji")
        .hint("Use the original files: many programs drop these tags");

  double takeoff = in.takeoff_height_m.value_or(0.0);
  if (in.takeoff_height_m && in.takeoff_datum == "egm96") {
    geometry::Geodetic place = photos.front().position;
    place.height_m = takeoff;
    takeoff += geodesy::geoid_undulation("egm96", place);
  }
  survey.manifest.origin = origin_of(in, heights, photos, takeoff);
  const geodesy::LocalFrame frame_of_survey(survey.manifest.origin.position);

  std::vector<std::string> stems;
  for (const auto& photo : photos) {
    imported.image_names.push_back(photo.file.filename().string());
    imported.image_files.push_back(photo.file);
    stems.push_back(photo.file.stem().string());
  }
  const auto turned = stems_named(in.rotate, stems);
  const auto ids = frame_ids_for(imported.image_names);
  Cameras cameras(survey.manifest);
  bool flight_yaw = false, timed = true;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const Photo& photo = photos[i];
    geometry::Geodetic position = photo.position;
    position.height_m = heights == HeightSource::rtk ? *photo.metadata.dji.absolute_altitude_m
                                                     : takeoff + *photo.metadata.dji.relative_altitude_m;
    survey::Frame frame;
    frame.id = ids[i];
    frame.time_ns = photo.metadata.civil_time_ns.value_or(0);
    timed = timed && photo.metadata.civil_time_ns.has_value();
    frame.T_world_camera = {camera::enu_from_camera(photo.angles), frame_of_survey.to_local(position)};
    if (turned[i]) frame.T_world_camera.rotation = camera::turned_half(frame.T_world_camera.rotation);
    frame.camera = cameras.id_of(given_camera ? *given_camera : *dji_camera(photo.metadata, from_dewarp),
                                 photo.metadata, turned[i]);
    set_sigmas(photo.metadata.dji, frame);
    flight_yaw = flight_yaw || !photo.gimbal_yaw;
    survey.frames.push_back(std::move(frame));
  }

  survey::Source poses;
  poses.kind = "poses";
  poses.path = io::file_reference(in.images, in.common.survey_folder);
  poses.convention = "DJI gimbal yaw, pitch, roll against north-east-down in the order ZYX (pitch -90 looks down)" +
                     std::string(flight_yaw ? ", flight yaw where a photograph has no gimbal yaw" : "") +
                     "; EXIF latitude and longitude as WGS84; " + height_sentence(in, heights) + ".";
  const bool type_said =
      std::all_of(photos.begin(), photos.end(), [](const Photo& p) { return !p.metadata.dji.altitude_type.empty(); });
  poses.confidence = flight_yaw                                   ? survey::Confidence::assumed
                     : heights == HeightSource::rtk && !type_said ? survey::Confidence::inferred
                                                                  : survey::Confidence::declared;
  poses.crs = "EPSG:4326";
  poses.height_type = survey.manifest.origin.height_type;
  survey.manifest.sources.push_back(poses);
  survey::Source images;
  images.kind = "images";
  images.path = poses.path;
  images.convention = "Raw pixels, no EXIF rotation applied, first pixel's centre at (0.5, 0.5); intrinsics " +
                      std::string(from_dewarp ? "from DewarpData."
                                              : "from the 35 mm equivalent focal length over 36 mm of image "
                                                "width, principal point at the centre, no distortion.");
  if (!in.rotate.empty())
    images.convention +=
        " Poses of " + in.rotate + " were turned by 180 degrees about the optical axis, as their pixels were.";
  images.confidence = given_camera ? survey::Confidence::declared : survey::Confidence::inferred;
  survey.manifest.sources.push_back(images);
  if (timed)
    survey.manifest.notes.emplace_back(
        "Times are DateTimeOriginal as written, without a zone: the time base is unknown.");
  note_oddities(photos, survey.manifest);
  return finish_import(std::move(imported), in.common, 1.0, out, ctx);
}

}  // namespace cairn::pipeline
