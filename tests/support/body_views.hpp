// Views of single bodies from a drone's flight, and the boxes around them: circle and lawn-mower passes of a 640 x 480
// camera that looks 60 deg down from 17 m. The bodies are ellipsoids, exactly, or clouds of surface points.
#pragma once

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

#include "base/angle.hpp"
#include "base/random.hpp"
#include "camera/projection.hpp"
#include "survey/survey.hpp"
#include "survey/target.hpp"

namespace cairn::testing {

using geometry::Mat2;
using geometry::Mat3;
using geometry::PixelBox;
using geometry::Vec2;
using geometry::Vec3;

// Camera that looks towards `yaw` [rad, clockwise from north], `down` [rad] below the horizon, level.
inline Mat3 looking(double yaw, double down) {
  const Vec3 level(std::sin(yaw), std::cos(yaw), 0.0);
  Mat3 r;
  r.col(0) = Vec3(std::cos(yaw), -std::sin(yaw), 0.0);
  r.col(2) = std::cos(down) * level - std::sin(down) * Vec3::UnitZ();
  r.col(1) = r.col(2).cross(r.col(0));
  return r;
}

inline survey::Camera r200() {
  survey::Camera camera;
  camera.id = survey::CameraId(1);
  camera.width_px = 640;
  camera.height_px = 480;
  camera.fx_px = camera.fy_px = 381.36;
  camera.cx_px = 320.0;
  camera.cy_px = 240.0;
  return camera;
}

// Ellipsoid { p : (p - c)^T Q^-1 (p - c) <= 1 }.
struct Ellipsoid {
  Vec3 centre = Vec3::Zero();
  Mat3 q = Mat3::Identity();
};

inline Ellipsoid ellipsoid(const Vec3& centre, const Vec3& semi_axes, const Mat3& rotation = Mat3::Identity()) {
  return {centre, rotation * semi_axes.cwiseAbs2().asDiagonal() * rotation.transpose()};
}

// Tight box of its outline in a pinhole image, from the dual conic C* = K (Q - c c^T) K^T. Empty where the camera is
// inside, or the ellipsoid is not wholly in front.
inline std::optional<PixelBox> tight_box(const survey::Camera& camera, const geometry::RigidTransform& T_world_camera,
                                         const Ellipsoid& body) {
  const Mat3 r = T_world_camera.rotation.transpose();
  const Vec3 c = r * (body.centre - T_world_camera.translation);
  const Mat3 dual = r * body.q * r.transpose() - c * c.transpose();
  if (!(dual(2, 2) < 0.0) || !(c.z() > 0.0)) return std::nullopt;
  const auto range = [&](int i, double f, double principal) {
    const double root = std::sqrt(dual(i, 2) * dual(i, 2) - dual(i, i) * dual(2, 2));
    const double a = (dual(i, 2) + root) / dual(2, 2), b = (dual(i, 2) - root) / dual(2, 2);
    return Vec2(f * std::min(a, b) + principal, f * std::max(a, b) + principal);
  };
  const Vec2 u = range(0, camera.fx_px, camera.cx_px), v = range(1, camera.fy_px, camera.cy_px);
  return PixelBox{u.x(), v.x(), u.y(), v.y()};
}

// The same of surface points. Empty where one is not in front.
inline std::optional<PixelBox> tight_box(const survey::Camera& camera, const geometry::RigidTransform& T_world_camera,
                                         const std::vector<Vec3>& points) {
  PixelBox box{1e300, 1e300, -1e300, -1e300};
  for (const auto& p : points) {
    const auto pixel = camera::project_world(camera, T_world_camera, p);
    if (!pixel) return std::nullopt;
    box = {std::min(box.xmin, pixel->x()), std::min(box.ymin, pixel->y()), std::max(box.xmax, pixel->x()),
           std::max(box.ymax, pixel->y())};
  }
  return box;
}

// Poses as flown; the survey holds them as recorded.
struct BodyViews {
  survey::Survey survey;
  std::vector<geometry::RigidTransform> flown;  // of each frame

  explicit BodyViews(const survey::Camera& camera = r200()) { survey.manifest.cameras.push_back(camera); }

  void frame(const Vec3& at, const Mat3& rotation) {
    survey::Frame f;
    f.id = survey::FrameId(static_cast<std::int64_t>(survey.frames.size()) + 1);
    f.camera = survey::CameraId(1);
    f.time_ns = f.id.value * 500'000'000;
    f.T_world_camera = {rotation, at};
    survey.frames.push_back(f);
    flown.push_back(f.T_world_camera);
  }
  // The camera's axis meets the middle of the circle at height 0.
  void circle(const Vec2& middle, double height, double down_deg, int count, double phase = 0.0) {
    const double down = base::deg_to_rad(down_deg), radius = height / std::tan(down);
    for (int i = 0; i < count; ++i) {
      const double yaw = phase + 2.0 * std::numbers::pi * i / count;
      frame(Vec3(middle.x() - radius * std::sin(yaw), middle.y() - radius * std::cos(yaw), height), looking(yaw, down));
    }
  }
  // A line northwards, 60 deg down.
  void line(double east, double north_from, double north_to, double height, double step) {
    for (double north = north_from; north <= north_to; north += step)
      frame(Vec3(east, north, height), looking(0.0, base::deg_to_rad(60.0)));
  }

  // Boxes of a body wherever it is in the image (sides at the border are the border), every side moved by sigma_px.
  template <typename Body>
  survey::Target boxes(const Body& body, const Vec3& start, double sigma_px = 0.0, std::uint64_t seed = 0) {
    survey::Target target;
    target.id = survey::TargetId(1);
    target.state = survey::TargetState::converged;
    target.centre = start;
    base::Random random(seed, "body boxes", 0);
    const auto& camera = survey.manifest.cameras.front();
    const double w = static_cast<double>(camera.width_px), h = static_cast<double>(camera.height_px);
    for (std::size_t i = 0; i < survey.frames.size(); ++i) {
      auto box = tight_box(camera, flown[i], body);
      if (!box) continue;
      const auto side = [&](double value, double limit) {
        return std::clamp(value + (value > 0.0 && value < limit ? sigma_px * random.normal() : 0.0), 0.0, limit);
      };
      *box = {side(box->xmin, w), side(box->ymin, h), side(box->xmax, w), side(box->ymax, h)};
      if (!(box->width() > 2.0 && box->height() > 2.0)) continue;
      survey::Detection d;
      d.id = survey::DetectionId(static_cast<std::int64_t>(survey.detections.size()) + 1);
      d.frame = survey.frames[i].id;
      d.object_class = "pbr";
      d.box = *box;
      survey.detections.push_back(d);
      target.detections.push_back(d.id);
    }
    return target;
  }
};

}  // namespace cairn::testing
