// OpenSfM reconstructions (those of OpenDroneMap too): reconstruction.json and tracks.csv.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/geodetic.hpp"
#include "geometry/rigid_transform.hpp"
#include "survey/camera.hpp"

namespace cairn::io {

struct OpensfmShot {
  std::string image;                        // its name in the images folder
  std::size_t camera = 0;                   // index into cameras
  geometry::RigidTransform T_world_camera;  // inverted here: the file holds world-to-camera, angle-axis
  std::optional<double> capture_time_s;     // since 1970, of the EXIF date without a zone
  std::optional<double> gps_dop_m;          // OpenSfM's 1 sigma of the GPS position
};

struct OpensfmObservation {
  std::size_t shot = 0;                           // index into shots
  geometry::Vec2 pixel = geometry::Vec2::Zero();  // corner convention, px of the camera's size
};

struct OpensfmPoint {
  std::int64_t id = 0;
  geometry::Vec3 position = geometry::Vec3::Zero();
  std::vector<OpensfmObservation> observations;  // by shot; from the tracks, empty without
};

// One reconstruction: topocentric east-north-up, metres, about the reference.
struct OpensfmModel {
  std::vector<survey::Camera> cameras;  // ids 1, 2, ... in the file's order, name = OpenSfM's key
  std::vector<OpensfmShot> shots;       // by image name
  std::vector<OpensfmPoint> points;     // ascending id
  std::optional<geometry::Geodetic> reference;
  std::vector<std::string> left_out;  // images of other reconstructions of the file, which are not connected with it
  std::vector<std::string> notes;     // sentences for people
};

// OpenSfM's normalised coordinates have their origin at the image's centre and the longer side as unit; with pixels in
// the corner convention that is  u = x max(w, h) + w / 2,  v = y max(w, h) + h / 2.
[[nodiscard]] geometry::Vec2 opensfm_pixel(const geometry::Vec2& normalised, double width_px, double height_px);

// A camera's members: projection_type perspective, simple_radial, radial, brown, fisheye or fisheye_opencv; any other
// is refused by its name. Throws invalid_input (without file).
//
// The reconstruction with most shots is taken. Poses must be finite, cameras known, point ids integers; angle-axis and
// translation of every shot are needed. `tracks` (versions 0, 1 and 2: image, track, feature, x, y, ... separated by
// tabs) gives the points' observations; rows of other tracks or images are counted in a note. Throws invalid_input with
// the file and member or line.
[[nodiscard]] OpensfmModel parse_opensfm(std::string_view reconstruction, std::string_view tracks,
                                         const std::filesystem::path& reconstruction_file,
                                         const std::filesystem::path& tracks_file);

// `path`: the JSON file, or the folder that holds reconstruction.json (or opensfm/reconstruction.json, as
// OpenDroneMap's projects do). Tracks: the given file, else tracks.csv beside it where there is one. The reference: in
// the reconstruction, else reference_lla.json beside it. Throws not_found.
[[nodiscard]] OpensfmModel read_opensfm(const std::filesystem::path& path, const std::filesystem::path& tracks = {});

}  // namespace cairn::io
