// A table of frames -> survey.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "pipeline/import_survey.hpp"

namespace cairn::pipeline {

struct ImportCsvInputs {
  ImportInputs common;
  std::filesystem::path table;
  std::filesystem::path images;  // folder of the images; "" = the image column is kept as a name only
  std::string camera;            // as parse_camera reads it
  std::string pose;              // with quaternions: "camera-to-world" or "world-to-camera"
  std::string angles;            // with yaw, pitch, roll: "gimbal" or "nadir-body" (camera::CameraMount)
  std::string time_base = "unknown";
};

// Columns are found by name, never by place: `image`; a position `x_m,y_m,z_m` (local ENU; also x,y,z)
// or `latitude_deg,longitude_deg,height_m` (also lat,lon,height); a rotation `qw,qx,qy,qz` or
// `yaw_deg,pitch_deg,roll_deg` (also yaw,pitch,roll: degrees). Optional: frame_id, time_ns, sigma_xy_m,
// sigma_z_m, sigma_rot_deg. With world-to-camera and x,y,z, these are the translation t of
// X_cam = R X_world + t; latitude and longitude are always the camera's own place.
// Throws invalid_input naming what is needed where columns are missing or a value is wrong,
// invalid_argument where a convention is not declared.
[[nodiscard]] Outcome import_csv(const ImportCsvInputs& in, const std::filesystem::path& out, base::RunContext& ctx);

}  // namespace cairn::pipeline
