// COLMAP sparse models: cameras, images, points3D, as text or binary.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/rigid_transform.hpp"
#include "survey/camera.hpp"

namespace cairn::io {

// A key point that belongs to a 3-D point; the others are not kept.
struct ColmapObservation {
  std::int64_t index = 0;                         // of the key point in its image's list
  std::int64_t point = 0;                         // id in points3D
  geometry::Vec2 pixel = geometry::Vec2::Zero();  // corner convention: COLMAP's first pixel centre is (0.5, 0.5)
};

struct ColmapImage {
  std::int64_t id = 0;
  std::string name;  // path relative to the image folder
  std::int64_t camera = 0;
  geometry::RigidTransform T_world_camera;      // inverted here: the file holds world-to-camera
  std::vector<ColmapObservation> observations;  // ascending index; empty where the image sees no point
};

struct ColmapPoint {
  std::int64_t id = 0;
  geometry::Vec3 position = geometry::Vec3::Zero();  // in the model's frame and unit
  std::array<std::uint8_t, 3> rgb{};
  double error_px = 0.0;  // mean reprojection error; -1 where COLMAP had not computed it
};

struct ColmapModel {
  std::vector<survey::Camera> cameras;  // ascending id, COLMAP's ids
  std::vector<ColmapImage> images;      // ascending id
  std::vector<ColmapPoint> points;      // ascending id
  bool binary = false;
  std::vector<std::string> notes;  // sentences for people: files that were not used, observations without a point
};

// Contents of the three files. `points` may be empty: then there are no points.
struct ColmapFiles {
  std::string_view cameras, images, points;
  std::filesystem::path folder;  // for messages
};

// Camera models SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, OPENCV_FISHEYE; any other is
// refused by its name. Quaternions must have norm 1 within 1e-3, everything must be finite, ids unique,
// cameras known, and every track element must be a key point that names the point (this finds mixed-up
// files). Counts are checked against the bytes that are left before memory is reserved. Throws
// invalid_input with file and line, or byte offset.
[[nodiscard]] ColmapModel parse_colmap_text(const ColmapFiles& files);
[[nodiscard]] ColmapModel parse_colmap_binary(const ColmapFiles& files);

// Reads a model folder; the binary files where both kinds exist, as COLMAP does. Files of rigs and
// frames are not read: a note says so. Cost linear in bytes; memory: the three files and the model.
[[nodiscard]] ColmapModel read_colmap(const std::filesystem::path& folder);

}  // namespace cairn::io
