// The Brighton Beach survey as records, read by a few lines of its own, so that a stage's test
// does not depend on the importers. World = colmap_enu.
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "geometry/rigid_transform.hpp"
#include "support/data.hpp"
#include "survey/survey.hpp"

namespace cairn::testing {

using CsvRow = std::map<std::string, std::string>;

inline std::vector<CsvRow> read_csv_rows(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path.string());
  const auto split = [](std::string line) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    std::vector<std::string> cells;
    std::stringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    return cells;
  };
  std::string line;
  std::getline(file, line);
  const auto header = split(line);
  std::vector<CsvRow> rows;
  while (std::getline(file, line)) {
    const auto cells = split(line);
    CsvRow row;
    for (std::size_t i = 0; i < header.size(); ++i) row[header[i]] = i < cells.size() ? cells[i] : "";
    rows.push_back(std::move(row));
  }
  return rows;
}

// Frames 18..35 by their number in the file name; the camera; the sparse points as ties without observations.
inline survey::Survey brighton_beach_poses() {
  const auto folder = sample("brighton_beach") / "colmap_enu";
  survey::Survey result;
  survey::Camera camera;
  camera.id = survey::CameraId(1);
  camera.name = "FC300S";
  camera.model = survey::CameraModel::radial;
  camera.width_px = 4000;
  camera.height_px = 2250;
  std::string line, word;
  std::ifstream cameras(folder / "cameras.txt");
  while (std::getline(cameras, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::stringstream s(line);
    s >> word >> word >> word >> word >> camera.fx_px >> camera.cx_px >> camera.cy_px >> camera.k1 >> camera.k2;
    camera.fy_px = camera.fx_px;
  }
  result.manifest.cameras.push_back(camera);

  std::ifstream images(folder / "images.txt");
  std::map<std::int64_t, survey::Frame> frames;
  while (std::getline(images, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::stringstream s(line);
    geometry::Quaternion q;
    geometry::RigidTransform T_camera_world;
    std::string name;
    s >> word >> q.qw >> q.qx >> q.qy >> q.qz >> T_camera_world.translation.x() >> T_camera_world.translation.y() >>
        T_camera_world.translation.z() >> word >> name;
    T_camera_world.rotation = geometry::rotation_matrix(q);
    survey::Frame frame;
    frame.id = survey::FrameId(std::stoll(name.substr(4, 4)));
    frame.camera = camera.id;
    frame.image = name;
    frame.T_world_camera = T_camera_world.inverse();
    frames[frame.id.value] = frame;
    std::getline(images, line);  // its feature points
  }
  for (const auto& [id, frame] : frames) result.frames.push_back(frame);

  std::ifstream points(folder / "points3D.txt");
  while (std::getline(points, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::stringstream s(line);
    survey::TiePoint tie;
    s >> word >> tie.p_world.x() >> tie.p_world.y() >> tie.p_world.z();
    tie.id = survey::TiePointId(static_cast<std::int64_t>(result.ties.size()) + 1);
    result.ties.push_back(tie);
  }
  if (result.frames.size() != 18) throw std::runtime_error("Brighton Beach: 18 frames expected");
  return result;
}

// Rows of detections.csv or labels.csv as detections.
inline std::vector<survey::Detection> brighton_beach_boxes(const std::vector<CsvRow>& rows) {
  std::vector<survey::Detection> result;
  for (const auto& row : rows) {
    survey::Detection d;
    d.id = survey::DetectionId(static_cast<std::int64_t>(result.size()) + 1);
    d.frame = survey::FrameId(std::stoll(row.at("frame")));
    d.object_class = row.at("class");
    d.score = row.contains("score") ? std::stod(row.at("score")) : 1.0;
    d.box = {std::stod(row.at("xmin_px")), std::stod(row.at("ymin_px")), std::stod(row.at("xmax_px")),
             std::stod(row.at("ymax_px"))};
    result.push_back(d);
  }
  return result;
}

inline survey::Survey brighton_beach_survey() {
  survey::Survey result = brighton_beach_poses();
  result.detections = brighton_beach_boxes(read_csv_rows(sample("brighton_beach") / "detections.csv"));
  return result;
}

}  // namespace cairn::testing
