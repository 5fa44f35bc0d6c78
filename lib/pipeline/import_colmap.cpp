#include "pipeline/import_colmap.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "camera/projection.hpp"
#include "io/colmap.hpp"
#include "io/image.hpp"
#include "io/image_metadata.hpp"
#include "io/survey_folder.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;

constexpr double kSizeTolerance = 1.0;  // px: a resize rounds each side

std::string size_text(std::int64_t width, std::int64_t height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

// Files of all images; names every one that is missing.
std::vector<fs::path> locate_images(const std::vector<io::ColmapImage>& images, const fs::path& folder) {
  std::error_code code;
  if (!fs::is_directory(folder, code))
    throw Error(ErrorCode::not_found, "no such folder of images").file(folder.string()).hint("Check --images");
  constexpr std::size_t kShown = 10;
  std::vector<fs::path> files;
  std::string missing;
  std::size_t count = 0;
  for (const auto& image : images) {
    files.push_back(folder / image.name);
    if (fs::is_regular_file(files.back(), code)) continue;
    if (++count <= kShown) missing += (missing.empty() ? "" : ", ") + image.name;
  }
  if (count > kShown) missing += " and " + std::to_string(count - kShown) + " more";
  if (count > 0)
    throw Error(ErrorCode::not_found,
                std::to_string(count) + " of " + std::to_string(images.size()) + " images missing")
        .file(folder.string())
        .found(missing)
        .hint("Point --images at the folder that holds the images of the model");
  return files;
}

// The factor from the camera's pixels to the image file's.
double scale_of(const survey::Camera& camera, const io::ImageHeader& image, const fs::path& file,
                const std::optional<double>& given) {
  const auto width = static_cast<double>(camera.width_px), height = static_cast<double>(camera.height_px);
  const double scale = given.value_or(static_cast<double>(image.width_px) / width);
  if (std::abs(width * scale - static_cast<double>(image.width_px)) > kSizeTolerance ||
      std::abs(height * scale - static_cast<double>(image.height_px)) > kSizeTolerance)
    throw Error(ErrorCode::failed_precondition, "image does not have the size of its camera")
        .file(file.string())
        .found(size_text(image.width_px, image.height_px) + " px")
        .allowed(size_text(camera.width_px, camera.height_px) + " px times " + base::to_text(scale))
        .hint("Use the images of this model, or correct --scale-images");
  return scale;
}

struct Sizes {
  std::vector<double> scale_of_camera;  // by index of the camera
  double common = 1.0;                  // the one scale of all, for boxes
  bool one_scale = true;
};

Sizes check_sizes(const io::ColmapModel& model, const std::vector<fs::path>& files, const std::optional<double>& given,
                  base::RunContext& ctx) {
  Sizes sizes;
  sizes.scale_of_camera.assign(model.cameras.size(), 0.0);
  for (std::size_t i = 0; i < model.images.size(); ++i) {
    ctx.check_stop();
    ctx.progress("images", i, model.images.size());
    const auto camera = static_cast<std::size_t>(
        std::lower_bound(model.cameras.begin(), model.cameras.end(), survey::CameraId(model.images[i].camera),
                         [](const survey::Camera& c, survey::CameraId wanted) { return c.id < wanted; }) -
        model.cameras.begin());
    const double scale = scale_of(model.cameras[camera], io::read_image_header(files[i]), files[i], given);
    double& known = sizes.scale_of_camera[camera];
    if (known != 0.0 && known != scale)
      throw Error(ErrorCode::failed_precondition, "images of one camera have different sizes")
          .file(files[i].string())
          .found("scale " + base::to_text(scale))
          .allowed("scale " + base::to_text(known));
    known = scale;
    if (i == 0) sizes.common = scale;
    sizes.one_scale = sizes.one_scale && scale == sizes.common;
  }
  ctx.progress("images", model.images.size(), model.images.size());
  return sizes;
}

// Capture times from EXIF, where every image has one. They carry no zone.
void add_times(Imported& imported) {
  std::vector<std::int64_t> times;
  for (const auto& file : imported.image_files) {
    std::optional<std::int64_t> time;
    try {
      time = io::read_image_metadata(file).civil_time_ns;
    } catch (const Error&) {
      return;  // the picture itself was readable; its tags are not needed here
    }
    if (!time) return;
    times.push_back(*time);
  }
  for (std::size_t i = 0; i < times.size(); ++i) imported.survey.frames[i].time_ns = times[i];
}

void add_ties(const io::ColmapModel& model, const std::vector<survey::FrameId>& ids,
              const std::map<std::int64_t, double>& scale_by_camera, survey::Survey& survey) {
  for (const auto& point : model.points) survey.ties.push_back({survey::TiePointId(point.id), point.position, {}});
  for (std::size_t i = 0; i < model.images.size(); ++i) {
    const double scale = scale_by_camera.at(model.images[i].camera);
    for (const auto& seen : model.images[i].observations) {
      const auto it =
          std::lower_bound(survey.ties.begin(), survey.ties.end(), survey::TiePointId(seen.point),
                           [](const survey::TiePoint& tie, survey::TiePointId wanted) { return tie.id < wanted; });
      it->observations.push_back({ids[i], seen.pixel * scale});
    }
  }
}

}  // namespace

Outcome import_colmap(const ImportColmapInputs& in, const fs::path& out, base::RunContext& ctx) {
  if (!in.common.origin || !in.common.height_type)
    throw Error(ErrorCode::invalid_argument, "a COLMAP model does not say where it is")
        .allowed("--origin LAT,LON,HEIGHT and --height-type")
        .hint("Give the origin of the model's east-north-up frame");
  if (in.scale_images && !(*in.scale_images > 0.0 && std::isfinite(*in.scale_images)))
    throw Error(ErrorCode::invalid_argument, "scale of the images is not positive")
        .found(base::to_text(*in.scale_images))
        .allowed("more than 0");
  const io::ColmapModel model = io::read_colmap(in.model);
  Imported imported;
  survey::Survey& survey = imported.survey;
  survey.manifest.origin = {*in.common.origin, *in.common.height_type, {}};
  imported.image_files = locate_images(model.images, in.images);
  const Sizes sizes = check_sizes(model, imported.image_files, in.scale_images, ctx);

  std::map<std::int64_t, double> scale_by_camera;
  for (std::size_t i = 0; i < model.cameras.size(); ++i) {
    const double scale = sizes.scale_of_camera[i];
    if (scale == 0.0) continue;  // no image uses it
    scale_by_camera[model.cameras[i].id.value] = scale;
    survey.manifest.cameras.push_back(camera::scaled(model.cameras[i], scale));
  }
  for (const auto& image : model.images) imported.image_names.push_back(image.name);
  const auto ids = frame_ids_for(imported.image_names);
  for (std::size_t i = 0; i < model.images.size(); ++i) {
    survey::Frame frame;
    frame.id = ids[i];
    frame.camera = survey::CameraId(model.images[i].camera);
    frame.T_world_camera = model.images[i].T_world_camera;
    survey.frames.push_back(std::move(frame));
  }
  add_times(imported);
  add_ties(model, ids, scale_by_camera, survey);

  survey::Source poses;
  poses.kind = "poses";
  poses.path = io::file_reference(in.model, in.common.survey_folder);
  poses.convention =
      "COLMAP world-to-camera poses (X_cam = R X_world + t, Hamilton qw qx qy qz, camera x right, y down, z forward), "
      "inverted; the model's frame is taken as east-north-up metres about the given origin.";
  poses.confidence = survey::Confidence::declared;
  poses.crs = "local";
  poses.height_type = *in.common.height_type;
  survey.manifest.sources.push_back(poses);
  survey::Source images;
  images.kind = "images";
  images.path = io::file_reference(in.images, in.common.survey_folder);
  images.convention =
      "Raw pixels, no EXIF rotation applied, first pixel's centre at (0.5, 0.5); intrinsics and tie points "
      "multiplied by " +
      (sizes.one_scale ? base::to_text(sizes.common) : std::string("each camera's own factor")) +
      " to the pixels of the image files.";
  images.confidence =
      in.scale_images || sizes.common == 1.0 ? survey::Confidence::declared : survey::Confidence::inferred;
  survey.manifest.sources.push_back(images);
  survey.manifest.notes = model.notes;
  if (!in.common.detections.empty() && !in.common.detections_scale && !sizes.one_scale)
    throw Error(ErrorCode::invalid_argument, "the cameras have different scales, so the boxes' scale is not known")
        .hint("Add --detections-scale");
  return finish_import(std::move(imported), in.common, sizes.common, out, ctx);
}

}  // namespace cairn::pipeline
