// The Brighton Beach sample read with as little as a test needs, independent of the readers of `io`.
#pragma once

#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>

#include "base/angle.hpp"
#include "geodesy/local_frame.hpp"
#include "geometry/point_cloud.hpp"
#include "support/data.hpp"
#include "survey/survey.hpp"

namespace cairn::testing {

inline geometry::Geodetic brighton_beach_origin() {
  return {46.8426, -91.9940, 158.0};
}

inline std::ifstream open_sample(const std::string& name) {
  std::ifstream in(sample("brighton_beach/" + name));
  if (!in) throw std::runtime_error("sample brighton_beach/" + name + " is missing");
  return in;
}

// Poses and tie points of colmap_enu; images of 1600 px when scaled = 0.4.
inline survey::Survey brighton_beach_colmap(double scaled = 0.4) {
  survey::Survey result;
  result.manifest.origin.position = brighton_beach_origin();
  std::string line;
  auto cameras = open_sample("colmap_enu/cameras.txt");
  while (std::getline(cameras, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream in(line);
    survey::Camera c;
    std::string model;
    double width = 0, height = 0, f = 0;
    in >> c.id.value >> model >> width >> height >> f >> c.cx_px >> c.cy_px >> c.k1 >> c.k2;
    c.model = survey::CameraModel::radial;
    c.fx_px = c.fy_px = f * scaled;
    c.cx_px *= scaled;
    c.cy_px *= scaled;
    c.width_px = std::llround(width * scaled);
    c.height_px = std::llround(height * scaled);
    result.manifest.cameras.push_back(c);
  }
  std::map<std::int64_t, std::vector<geometry::Vec2>> pixels;
  std::map<std::int64_t, survey::Frame> frames;
  auto images = open_sample("colmap_enu/images.txt");
  while (std::getline(images, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream in(line);
    survey::Frame f;
    geometry::Quaternion q;
    geometry::RigidTransform T_camera_world;
    auto& t = T_camera_world.translation;
    in >> f.id.value >> q.qw >> q.qx >> q.qy >> q.qz >> t.x() >> t.y() >> t.z() >> f.camera.value >> f.image;
    T_camera_world.rotation = geometry::rotation_matrix(q);
    f.T_world_camera = T_camera_world.inverse();
    std::getline(images, line);
    std::istringstream points(line);
    double x = 0, y = 0;
    std::int64_t id = 0;
    while (points >> x >> y >> id) pixels[f.id.value].emplace_back(x * scaled, y * scaled);
    frames[f.id.value] = f;
  }
  for (const auto& [id, frame] : frames) result.frames.push_back(frame);
  std::map<std::int64_t, survey::TiePoint> ties;
  auto points = open_sample("colmap_enu/points3D.txt");
  while (std::getline(points, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream in(line);
    survey::TiePoint tie;
    double r = 0, g = 0, b = 0, error = 0;
    in >> tie.id.value >> tie.p_world.x() >> tie.p_world.y() >> tie.p_world.z() >> r >> g >> b >> error;
    std::int64_t image = 0;
    std::size_t index = 0;
    while (in >> image >> index) tie.observations.push_back({survey::FrameId(image), pixels.at(image).at(index)});
    ties[tie.id.value] = tie;
  }
  for (auto& [id, tie] : ties) result.ties.push_back(std::move(tie));
  return result;
}

// Poses as the aircraft wrote them (exif_poses.csv), with nothing known about turned rasters: position from
// the EXIF, gimbal yaw and pitch, camera of the 35 mm equivalent focal length.
inline survey::Survey brighton_beach_exif() {
  survey::Survey result;
  result.manifest.origin.position = brighton_beach_origin();
  survey::Camera camera;
  camera.id = survey::CameraId(1);
  camera.width_px = 1600;
  camera.height_px = 900;
  camera.fx_px = camera.fy_px = 2285.714 * 0.4;
  camera.cx_px = 800.0;
  camera.cy_px = 450.0;
  result.manifest.cameras.push_back(camera);
  const geodesy::LocalFrame local(brighton_beach_origin());
  auto in = open_sample("exif_poses.csv");
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    survey::Frame frame;
    frame.image = cells.at(0);
    frame.id = survey::FrameId(std::stoll(cells.at(1)));
    frame.camera = camera.id;
    frame.T_world_camera.translation =
        local.to_local({std::stod(cells.at(3)), std::stod(cells.at(4)), std::stod(cells.at(5))});
    const double yaw = base::deg_to_rad(std::stod(cells.at(8))), pitch = base::deg_to_rad(std::stod(cells.at(9)));
    // R_ned_camera = Rz(yaw) Ry(pitch) R_body_camera.
    geometry::Mat3 body_camera, enu_ned;
    body_camera << 0, 0, 1, 1, 0, 0, 0, 1, 0;
    enu_ned << 0, 1, 0, 1, 0, 0, 0, 0, -1;
    frame.T_world_camera.rotation = enu_ned * geometry::axis_rotation(geometry::Vec3::UnitZ(), yaw) *
                                    geometry::axis_rotation(geometry::Vec3::UnitY(), pitch) * body_camera;
    result.frames.push_back(frame);
  }
  return result;
}

// Points of the sample cloud as stored: LAS 1.2, point format 3 (EPSG:32615, z as written).
inline geometry::PointCloud brighton_beach_cloud_utm() {
  std::ifstream in(sample("brighton_beach/model.las"), std::ios::binary);
  if (!in) throw std::runtime_error("sample brighton_beach/model.las is missing");
  const std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const auto read = [&](std::size_t at, auto& value) { std::memcpy(&value, bytes.data() + at, sizeof value); };
  std::uint32_t offset = 0, count = 0;
  std::uint16_t length = 0;
  double scale[3], shift[3];
  read(96, offset);
  read(105, length);
  read(107, count);
  read(131, scale);
  read(155, shift);
  geometry::PointCloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = offset + i * length;
    std::int32_t xyz[3];
    std::array<std::uint16_t, 3> rgb{};
    read(at, xyz);
    read(at + 28, rgb);
    cloud.positions.emplace_back(xyz[0] * scale[0] + shift[0], xyz[1] * scale[1] + shift[1],
                                 xyz[2] * scale[2] + shift[2]);
    cloud.colours.push_back(rgb);
  }
  return cloud;
}

}  // namespace cairn::testing
