// What the text and the binary reader of COLMAP models share.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "io/colmap.hpp"

namespace cairn::io {

// COLMAP's camera models (its src/sensor/models.h), with those cairn can hold marked.
struct ColmapCameraModel {
  int id;
  std::string_view name;
  std::size_t parameters;
  bool supported;
};
[[nodiscard]] const ColmapCameraModel* find_colmap_model(int id);
[[nodiscard]] const ColmapCameraModel* find_colmap_model(std::string_view name);

// Throws invalid_input naming the model where it is not supported.
void require_supported(const ColmapCameraModel& model);

// Throws invalid_input (without file and record) for sizes and parameters no camera has.
[[nodiscard]] survey::Camera make_colmap_camera(std::int64_t id, const ColmapCameraModel& model, double width,
                                                double height, std::span<const double> parameters);

// qw qx qy qz tx ty tz of the world-to-camera pose, inverted. Throws invalid_input.
[[nodiscard]] geometry::RigidTransform invert_colmap_pose(std::span<const double, 7> pose);

struct ColmapTrackElement {
  std::int64_t point, image, index;
};

// Sorts by id, checks ids, cameras and tracks, drops observations of points that are not there (with a
// note). File names are for messages.
void finish_colmap_model(ColmapModel& model, const std::vector<ColmapTrackElement>& tracks,
                         std::string_view images_file, std::string_view points_file);

}  // namespace cairn::io
