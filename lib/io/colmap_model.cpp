#include "io/colmap_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.hpp"
#include "base/number_text.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;

constexpr std::array<ColmapCameraModel, 11> kModels{{{0, "SIMPLE_PINHOLE", 3, true},
                                                     {1, "PINHOLE", 4, true},
                                                     {2, "SIMPLE_RADIAL", 4, true},
                                                     {3, "RADIAL", 5, true},
                                                     {4, "OPENCV", 8, true},
                                                     {5, "OPENCV_FISHEYE", 8, true},
                                                     {6, "FULL_OPENCV", 12, false},
                                                     {7, "FOV", 5, false},
                                                     {8, "SIMPLE_RADIAL_FISHEYE", 4, false},
                                                     {9, "RADIAL_FISHEYE", 5, false},
                                                     {10, "THIN_PRISM_FISHEYE", 12, false}}};

constexpr double kQuaternionTolerance = 1e-3;  // of |q|
constexpr double kMaxSide = 1e6;               // px

template <typename Record, typename IdOf>
void sort_and_refuse_twins(std::vector<Record>& records, IdOf&& id_of, std::string_view what, std::string_view file) {
  std::sort(records.begin(), records.end(), [&](const Record& a, const Record& b) { return id_of(a) < id_of(b); });
  for (std::size_t i = 1; i < records.size(); ++i)
    if (id_of(records[i]) == id_of(records[i - 1]))
      throw Error(ErrorCode::invalid_input, std::string(what) + " id appears twice")
          .file(file)
          .found(std::to_string(id_of(records[i])));
}

template <typename Record>
const Record* find_by_id(const std::vector<Record>& records, std::int64_t id) {
  const auto it = std::lower_bound(records.begin(), records.end(), id,
                                   [](const Record& record, std::int64_t wanted) { return record.id < wanted; });
  return it != records.end() && it->id == id ? &*it : nullptr;
}

void check_track(const ColmapModel& model, const ColmapTrackElement& element, std::string_view file) {
  const auto refuse = [&](const std::string& why) {
    throw Error(ErrorCode::invalid_input, why)
        .file(file)
        .record("point " + std::to_string(element.point))
        .found("image " + std::to_string(element.image) + ", key point " + std::to_string(element.index))
        .hint("Export the model again: its images and points do not belong together");
  };
  const ColmapImage* image = find_by_id(model.images, element.image);
  if (image == nullptr) refuse("track names an image that is not in the model");
  const auto it = std::lower_bound(image->observations.begin(), image->observations.end(), element.index,
                                   [](const ColmapObservation& o, std::int64_t wanted) { return o.index < wanted; });
  if (it == image->observations.end() || it->index != element.index || it->point != element.point)
    refuse("track names a key point that does not name the point");
}

}  // namespace

const ColmapCameraModel* find_colmap_model(int id) {
  return id >= 0 && id < static_cast<int>(kModels.size()) ? &kModels[static_cast<std::size_t>(id)] : nullptr;
}

const ColmapCameraModel* find_colmap_model(std::string_view name) {
  for (const auto& model : kModels)
    if (model.name == name) return &model;
  return nullptr;
}

void require_supported(const ColmapCameraModel& model) {
  if (!model.supported)
    throw Error(ErrorCode::invalid_input, "camera model that cairn does not hold")
        .found(model.name)
        .allowed("SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, OPENCV_FISHEYE")
        .hint("Run colmap image_undistorter, or reconstruct with --ImageReader.camera_model OPENCV");
}

survey::Camera make_colmap_camera(std::int64_t id, const ColmapCameraModel& model, double width, double height,
                                  std::span<const double> p) {
  require_supported(model);
  if (p.size() != model.parameters)
    throw Error(ErrorCode::invalid_input, "camera with the wrong number of parameters")
        .found(std::to_string(p.size()))
        .allowed(std::to_string(model.parameters) + " for " + std::string(model.name));
  for (const double value : p)
    if (!std::isfinite(value))
      throw Error(ErrorCode::invalid_input, "camera parameter is not finite").found(base::to_text(value));
  if (!(width >= 1.0 && width <= kMaxSide) || !(height >= 1.0 && height <= kMaxSide))
    throw Error(ErrorCode::invalid_input, "image size out of range")
        .found(base::to_text(width) + " x " + base::to_text(height))
        .allowed("1 to 1000000 px a side");
  survey::Camera c;
  c.id = survey::CameraId(id);
  c.name = "COLMAP camera " + std::to_string(id);
  c.width_px = static_cast<std::int64_t>(width);
  c.height_px = static_cast<std::int64_t>(height);
  const bool one_focal = model.id == 0 || model.id == 2 || model.id == 3;
  std::size_t next = 0;
  c.fx_px = p[next++];
  c.fy_px = one_focal ? c.fx_px : p[next++];
  c.cx_px = p[next++];
  c.cy_px = p[next++];
  switch (model.id) {
    case 2:
    case 3:
      c.model = survey::CameraModel::radial;
      c.k1 = p[next++];
      if (model.id == 3) c.k2 = p[next++];
      break;
    case 4:
      c.model = survey::CameraModel::brown;
      c.k1 = p[next++];
      c.k2 = p[next++];
      c.p1 = p[next++];
      c.p2 = p[next++];
      break;
    case 5:
      c.model = survey::CameraModel::fisheye;
      c.k1 = p[next++];
      c.k2 = p[next++];
      c.k3 = p[next++];
      c.k4 = p[next++];
      break;
    default: c.model = survey::CameraModel::pinhole;
  }
  if (!(c.fx_px > 0.0) || !(c.fy_px > 0.0))
    throw Error(ErrorCode::invalid_input, "focal length is not positive")
        .found(base::to_text(c.fx_px) + ", " + base::to_text(c.fy_px))
        .allowed("more than 0 px");
  return c;
}

geometry::RigidTransform invert_colmap_pose(std::span<const double, 7> pose) {
  for (const double value : pose)
    if (!std::isfinite(value))
      throw Error(ErrorCode::invalid_input, "pose is not finite").found(base::to_text(value)).allowed("finite numbers");
  const geometry::Quaternion q{pose[0], pose[1], pose[2], pose[3]};
  if (!(std::abs(q.norm() - 1.0) <= kQuaternionTolerance))
    throw Error(ErrorCode::invalid_input, "quaternion is not of unit length")
        .found("|q| = " + base::to_text(q.norm()))
        .allowed("1 within " + base::to_text(kQuaternionTolerance))
        .hint("The columns are QW, QX, QY, QZ, TX, TY, TZ");
  const geometry::RigidTransform T_camera_world{geometry::rotation_matrix(q), {pose[4], pose[5], pose[6]}};
  return T_camera_world.inverse();
}

void finish_colmap_model(ColmapModel& model, const std::vector<ColmapTrackElement>& tracks,
                         std::string_view images_file, std::string_view points_file) {
  sort_and_refuse_twins(
      model.cameras, [](const survey::Camera& c) { return c.id.value; }, "camera", images_file);
  sort_and_refuse_twins(
      model.images, [](const ColmapImage& i) { return i.id; }, "image", images_file);
  sort_and_refuse_twins(
      model.points, [](const ColmapPoint& p) { return p.id; }, "point", points_file);
  std::unordered_map<std::string_view, std::int64_t> names;
  for (const auto& image : model.images) {
    const auto camera =
        std::lower_bound(model.cameras.begin(), model.cameras.end(), image.camera,
                         [](const survey::Camera& c, std::int64_t wanted) { return c.id.value < wanted; });
    if (camera == model.cameras.end() || camera->id.value != image.camera)
      throw Error(ErrorCode::invalid_input, "image of an unknown camera")
          .file(images_file)
          .record("image " + image.name)
          .found(std::to_string(image.camera))
          .allowed("a camera of the cameras file");
    if (const auto [it, fresh] = names.emplace(image.name, image.id); !fresh)
      throw Error(ErrorCode::invalid_input, "two images of one name")
          .file(images_file)
          .record("image " + std::to_string(image.id))
          .found(image.name);
  }
  for (const auto& element : tracks) check_track(model, element, points_file);
  std::size_t dropped = 0;
  for (auto& image : model.images)
    dropped += std::erase_if(image.observations,
                             [&](const ColmapObservation& o) { return find_by_id(model.points, o.point) == nullptr; });
  if (dropped > 0)
    model.notes.push_back(std::to_string(dropped) +
                          " key points name a 3-D point that the model does not have; they were left out.");
}

}  // namespace cairn::io
