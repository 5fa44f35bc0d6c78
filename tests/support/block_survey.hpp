// A block of photographs from above with tie points, whose truth is known.
#pragma once

#include <cmath>

#include "adjustment/bundle.hpp"
#include "adjustment/bundle_datum.hpp"
#include "base/angle.hpp"
#include "base/random.hpp"
#include "camera/projection.hpp"
#include "geometry/alignment.hpp"

namespace cairn::testing {

inline geometry::Vec3 normal3(base::Random& random, double sigma) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return {sigma * x, sigma * y, sigma * z};
}

inline geometry::Mat3 small_turn(const geometry::Vec3& w) {
  return w.norm() > 0.0 ? geometry::axis_rotation(w.normalized(), w.norm())
                        : geometry::Mat3(geometry::Mat3::Identity());
}

// Moves every pose by noise of these sigmas an axis, and forgets where the points are.
inline void perturb(adjustment::BundleProblem& problem, double position_m, double rotation_deg, std::uint64_t seed) {
  base::Random random(seed, "perturb", 0);
  for (auto& frame : problem.frames) {
    frame.T_world_camera.translation += normal3(random, position_m);
    frame.T_world_camera.rotation =
        frame.T_world_camera.rotation * small_turn(normal3(random, base::deg_to_rad(rotation_deg)));
  }
  for (auto& tie : problem.ties) tie.p_world.setConstant(std::nan(""));
}

struct BlockOptions {
  int columns = 4, rows = 3, points = 400;
  double spacing_m = 12.0, height_m = 40.0, relief_m = 3.0, noise_px = 0.0;
  survey::CameraModel model = survey::CameraModel::radial;
  std::uint64_t seed = 1;
};

// Cameras of 1600 x 1200 px, f = 1100 px, tilted by a few degrees, in rows flown to and fro.
struct BlockSurvey {
  adjustment::BundleProblem truth;  // poses and points as they are; pixels with noise

  explicit BlockSurvey(const BlockOptions& o) {
    base::Random random(o.seed, "block", 0);
    survey::Camera camera;
    camera.id = survey::CameraId(1);
    camera.model = o.model;
    camera.width_px = 1600;
    camera.height_px = 1200;
    camera.fx_px = 1100.0;
    camera.fy_px = 1102.0;
    camera.cx_px = 803.0;
    camera.cy_px = 596.0;
    if (o.model != survey::CameraModel::pinhole) {
      camera.k1 = -0.02;
      camera.k2 = 0.005;
    }
    if (o.model == survey::CameraModel::brown) {
      camera.k3 = 0.001;
      camera.p1 = 0.0005;
      camera.p2 = -0.0003;
    }
    truth.cameras.push_back(camera);
    for (int row = 0; row < o.rows; ++row)
      for (int column = 0; column < o.columns; ++column) {
        survey::Frame frame;
        frame.id = survey::FrameId(10 + static_cast<std::int64_t>(truth.frames.size()));
        frame.camera = camera.id;
        geometry::Mat3 down;
        down << 1, 0, 0, 0, -1, 0, 0, 0, -1;
        const double yaw = row % 2 == 0 ? 0.3 : 0.3 + std::numbers::pi;
        frame.T_world_camera.rotation = geometry::axis_rotation(geometry::Vec3::UnitZ(), yaw) * down *
                                        small_turn(normal3(random, base::deg_to_rad(4.0)));
        frame.T_world_camera.translation =
            geometry::Vec3(o.spacing_m * column, o.spacing_m * row, o.height_m) + normal3(random, 0.7);
        truth.frames.push_back(frame);
      }
    const double east = o.spacing_m * (o.columns - 1), north = o.spacing_m * (o.rows - 1);
    for (int i = 0; i < o.points; ++i) {
      const double x = random.uniform(-15.0, east + 15.0), y = random.uniform(-12.0, north + 12.0);
      survey::TiePoint tie;
      tie.id = survey::TiePointId(i + 1);
      tie.p_world = {x, y, o.relief_m * random.normal()};
      tie.observations = seen(tie.p_world, random, o.noise_px);
      if (tie.observations.size() >= 2) truth.ties.push_back(tie);
    }
  }

  // Where the frames see a point.
  [[nodiscard]] std::vector<survey::TieObservation> seen(const geometry::Vec3& p, base::Random& random,
                                                         double noise_px) const {
    std::vector<survey::TieObservation> observations;
    for (const auto& frame : truth.frames) {
      auto pixel = camera::project_world(truth.cameras[0], frame.T_world_camera, p);
      if (!pixel) continue;
      pixel->x() += noise_px * random.normal();
      pixel->y() += noise_px * random.normal();
      if (camera::inside_image(truth.cameras[0], *pixel)) observations.push_back({frame.id, *pixel});
    }
    return observations;
  }

  // Poses moved by noise of these sigmas; the points are nowhere.
  [[nodiscard]] adjustment::BundleProblem perturbed(double position_m, double rotation_deg, std::uint64_t seed) const {
    auto problem = truth;
    perturb(problem, position_m, rotation_deg, seed);
    return problem;
  }
};

// Largest differences of poses between frames of the same ids.
struct PoseDifference {
  double position_m = 0.0, rotation_deg = 0.0;
};
inline PoseDifference pose_difference(const std::vector<survey::Frame>& a, const std::vector<survey::Frame>& b) {
  PoseDifference d;
  for (std::size_t i = 0; i < a.size(); ++i) {
    d.position_m = std::max(d.position_m, (a[i].T_world_camera.translation - b[i].T_world_camera.translation).norm());
    d.rotation_deg =
        std::max(d.rotation_deg, base::rad_to_deg(geometry::rotation_angle(a[i].T_world_camera.rotation.transpose() *
                                                                           b[i].T_world_camera.rotation)));
  }
  return d;
}

// Frames brought onto others by the similarity of their positions: what a block without a datum can be judged by.
inline std::vector<survey::Frame> aligned(const std::vector<survey::Frame>& frames,
                                          const std::vector<survey::Frame>& to) {
  std::vector<geometry::RigidTransform> a, b;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    a.push_back(frames[i].T_world_camera);
    b.push_back(to[i].T_world_camera);
  }
  const auto T = adjustment::align_poses(a, b);
  auto result = frames;
  for (auto& frame : result) frame.T_world_camera = geometry::transform_pose(T, frame.T_world_camera);
  return result;
}

}  // namespace cairn::testing
