#include "pipeline/import_opensfm.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "camera/projection.hpp"
#include "io/image.hpp"
#include "io/opensfm.hpp"
#include "io/survey_folder.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;

constexpr double kSizeTolerance = 1.0;  // px: a resize rounds each side

// The folder of the images: the given one, else where OpenSfM and OpenDroneMap keep them.
fs::path images_of(const ImportOpensfmInputs& in) {
  if (!in.images.empty()) return in.images;
  std::error_code code;
  const fs::path folder = fs::is_directory(in.input, code) ? in.input : in.input.parent_path();
  for (const auto& candidate : {folder / "images", folder.parent_path() / "images"})
    if (fs::is_directory(candidate, code)) return candidate;
  return {};
}

std::vector<fs::path> files_of(const io::OpensfmModel& model, const fs::path& folder) {
  std::vector<fs::path> files;
  std::string missing;
  std::size_t count = 0;
  constexpr std::size_t kShown = 10;
  std::error_code code;
  for (const auto& shot : model.shots) {
    files.push_back(folder / shot.image);
    if (fs::is_regular_file(files.back(), code)) continue;
    if (++count <= kShown) missing += (missing.empty() ? "" : ", ") + shot.image;
  }
  if (count > 0)
    throw Error(ErrorCode::not_found,
                std::to_string(count) + " of " + std::to_string(model.shots.size()) + " images missing")
        .file(folder.string())
        .found(missing)
        .hint("Point --images at the folder that holds the images of the reconstruction");
  return files;
}

// Image file pixels per pixel of each camera; 1 where there are no images.
std::vector<double> scales_of(const io::OpensfmModel& model, const std::vector<fs::path>& files,
                              base::RunContext& ctx) {
  std::vector<double> scales(model.cameras.size(), 0.0);
  for (std::size_t i = 0; i < files.size(); ++i) {
    ctx.check_stop();
    ctx.progress("images", i, files.size());
    const auto& camera = model.cameras[model.shots[i].camera];
    const auto image = io::read_image_header(files[i]);
    const double scale = static_cast<double>(image.width_px) / static_cast<double>(camera.width_px);
    double& known = scales[model.shots[i].camera];
    if (std::abs(static_cast<double>(camera.height_px) * scale - static_cast<double>(image.height_px)) >
            kSizeTolerance ||
        (known != 0.0 && known != scale))
      throw Error(ErrorCode::failed_precondition, "image does not have the size of its camera")
          .file(files[i].string())
          .found(std::to_string(image.width_px) + " x " + std::to_string(image.height_px) + " px")
          .allowed(std::to_string(camera.width_px) + " x " + std::to_string(camera.height_px) +
                   " px, or one multiple of it for all images of the camera")
          .hint("Use the images of this reconstruction");
    known = scale;
  }
  for (auto& scale : scales)
    if (scale == 0.0) scale = 1.0;
  return scales;
}

survey::Origin origin_of(const ImportOpensfmInputs& in, const io::OpensfmModel& model) {
  if (in.common.origin && !in.common.height_type)
    throw Error(ErrorCode::invalid_argument, "heights always name their datum").hint("Add --height-type to --origin");
  if (!in.common.origin && !model.reference)
    throw Error(ErrorCode::invalid_argument, "the reconstruction does not say where it is")
        .file(in.input.string())
        .allowed("reference_lla in the reconstruction or reference_lla.json beside it")
        .hint("Give --origin LAT,LON,HEIGHT and --height-type");
  return {in.common.origin ? *in.common.origin : *model.reference,
          in.common.height_type.value_or(survey::HeightType::unknown),
          {}};
}

void add_sources(const ImportOpensfmInputs& in, const io::OpensfmModel& model, const fs::path& images,
                 survey::Survey& survey) {
  survey::Source poses;
  poses.kind = "poses";
  poses.path = io::file_reference(in.input, in.common.survey_folder);
  poses.convention =
      "OpenSfM world-to-camera poses (angle-axis, camera x right, y down, z forward), inverted; world east-north-up "
      "metres about " +
      std::string(in.common.origin ? "the given origin." : "the reconstruction's reference_lla.");
  poses.confidence = survey::Confidence::declared;
  poses.crs = "local";
  poses.height_type = survey.manifest.origin.height_type;
  survey.manifest.sources.push_back(poses);
  if (!images.empty()) {
    survey::Source source;
    source.kind = "images";
    source.path = io::file_reference(images, in.common.survey_folder);
    source.convention =
        "Raw pixels, no EXIF rotation applied; OpenSfM's normalised coordinates (origin at the image's centre, longer "
        "side 1) as pixels with the first pixel's centre at (0.5, 0.5).";
    source.confidence = survey::Confidence::declared;
    survey.manifest.sources.push_back(source);
  }
  if (survey.manifest.origin.height_type == survey::HeightType::unknown)
    survey.manifest.notes.emplace_back(
        "The reference's altitude is that of the photographs' GPS tags: its datum is unknown.");
  survey.manifest.notes.insert(survey.manifest.notes.end(), model.notes.begin(), model.notes.end());
  survey.manifest.notes.emplace_back(
      "Times are the photographs' dates as OpenSfM read them, without a zone: the time base is unknown.");
}

}  // namespace

Outcome import_opensfm(const ImportOpensfmInputs& in, const fs::path& out, base::RunContext& ctx) {
  const auto model = io::read_opensfm(in.input, in.tracks);
  Imported imported;
  survey::Survey& survey = imported.survey;
  survey.manifest.origin = origin_of(in, model);
  const fs::path images = images_of(in);
  if (!images.empty()) imported.image_files = files_of(model, images);
  const auto scales = scales_of(model, imported.image_files, ctx);
  imported.image_files.resize(model.shots.size());
  for (std::size_t i = 0; i < model.cameras.size(); ++i)
    survey.manifest.cameras.push_back(camera::scaled(model.cameras[i], scales[i]));
  for (const auto& shot : model.shots) imported.image_names.push_back(shot.image);
  const auto ids = frame_ids_for(imported.image_names);
  for (std::size_t i = 0; i < model.shots.size(); ++i) {
    const auto& shot = model.shots[i];
    survey::Frame frame;
    frame.id = ids[i];
    frame.camera = model.cameras[shot.camera].id;
    frame.T_world_camera = shot.T_world_camera;
    constexpr double kNsPerSecond = 1e9;
    if (shot.capture_time_s && *shot.capture_time_s < 9e9)
      frame.time_ns = static_cast<std::int64_t>(std::llround(*shot.capture_time_s * kNsPerSecond));
    survey.frames.push_back(std::move(frame));
  }
  for (const auto& point : model.points) {
    survey::TiePoint tie;
    tie.id = survey::TiePointId(point.id);
    tie.p_world = point.position;
    for (const auto& seen : point.observations)
      tie.observations.push_back({ids[seen.shot], seen.pixel * scales[model.shots[seen.shot].camera]});
    survey.ties.push_back(std::move(tie));
  }
  for (const auto& image : model.left_out)
    imported.rejects.push_back(
        {"frame " + image, "other_reconstruction",
         "the image belongs to another reconstruction of the file, not connected with this one"});
  add_sources(in, model, images, survey);
  const double common = scales.empty() ? 1.0 : scales.front();
  if (!in.common.detections.empty() && !in.common.detections_scale &&
      !std::all_of(scales.begin(), scales.end(), [&](double s) { return s == common; }))
    throw Error(ErrorCode::invalid_argument, "the cameras have different scales, so the boxes' scale is not known")
        .hint("Add --detections-scale");
  return finish_import(std::move(imported), in.common, common, out, ctx);
}

}  // namespace cairn::pipeline
