// A small made-up survey: a level row of photos from above, and boxes of objects at known places.
#pragma once

#include <string>
#include <vector>

#include "survey/survey.hpp"

namespace cairn::testing {

struct NadirSurvey {
  survey::Survey survey;
  double height_m = 40.0;

  // `count` frames `spacing` metres apart along east, at height_m, looking down; 1000 x 1000 px, f = 1000 px:
  // 0.04 m a pixel on the ground, 40 m wide.
  explicit NadirSurvey(int count, double spacing = 8.0) {
    survey::Camera camera;
    camera.id = survey::CameraId(1);
    camera.width_px = camera.height_px = 1000;
    camera.fx_px = camera.fy_px = 1000.0;
    camera.cx_px = camera.cy_px = 500.0;
    survey.manifest.cameras.push_back(camera);
    for (int i = 0; i < count; ++i) {
      survey::Frame frame;
      frame.id = survey::FrameId(i + 1);
      frame.camera = camera.id;
      frame.time_ns = i + 1;
      frame.T_world_camera.rotation << 1, 0, 0, 0, -1, 0, 0, 0, -1;
      frame.T_world_camera.translation = {spacing * i, 0.0, height_m};
      survey.frames.push_back(frame);
    }
  }

  survey::Detection& box(survey::FrameId frame, const geometry::PixelBox& b, const std::string& object_class) {
    survey::Detection d;
    d.id = survey::DetectionId(static_cast<std::int64_t>(survey.detections.size()) + 1);
    d.frame = frame;
    d.object_class = object_class;
    d.score = 0.9;
    d.box = b;
    survey.detections.push_back(d);
    return survey.detections.back();
  }

  // A box of `size_m` about `at` in every frame that shows it whole.
  int object(const geometry::Vec3& at, double size_m = 1.0, const std::string& object_class = "boulder") {
    int shown = 0;
    for (const auto& frame : survey.frames) {
      const geometry::Vec3 p = frame.T_world_camera.rotation.transpose() * (at - frame.T_world_camera.translation);
      const double u = 1000.0 * p.x() / p.z() + 500.0, v = 1000.0 * p.y() / p.z() + 500.0;
      const double half = 0.5 * size_m * 1000.0 / p.z();
      if (u < half + 10 || u > 990 - half || v < half + 10 || v > 990 - half) continue;
      box(frame.id, {u - half, v - half, u + half, v + half}, object_class);
      ++shown;
    }
    return shown;
  }
};

}  // namespace cairn::testing
