// Problems of "Bundle Adjustment in the Large" (Agarwal et al. 2010): the text format, and a made-up one like it.
#pragma once

#include <cmath>
#include <fstream>
#include <stdexcept>
#include <string>

#include "adjustment/bundle_system.hpp"
#include "base/random.hpp"

namespace cairn::testing {

// A camera of BAL is p = R X + t, u = -p.xy / p.z, pixel = f (1 + k1 |u|^2 + k2 |u|^4) u: x right, y up, z backward
// about the principal point. Ours has y down and z forward, so y of the pixels changes its sign; nothing else does.
struct BalCamera {
  double rotation[3], translation[3], f, k1, k2;
};

inline void add_bal_camera(adjustment::BundleSystem& system, const BalCamera& bal) {
  survey::Camera camera;
  camera.id = survey::CameraId(static_cast<std::int64_t>(system.cameras.size()) + 1);
  camera.model = survey::CameraModel::radial;
  camera.width_px = camera.height_px = 4000;  // BAL does not say
  camera.fx_px = camera.fy_px = bal.f;
  camera.k1 = bal.k1;
  camera.k2 = bal.k2;
  system.camera_of.push_back(static_cast<std::int32_t>(system.cameras.size()));
  system.cameras.push_back(camera);
  geometry::RigidTransform T_bal_world;
  T_bal_world.rotation = adjustment::exp_rotation({bal.rotation[0], bal.rotation[1], bal.rotation[2]});
  T_bal_world.translation = {bal.translation[0], bal.translation[1], bal.translation[2]};
  const geometry::Mat3 flip = geometry::Vec3(1, -1, -1).asDiagonal();
  const geometry::RigidTransform T_bal_camera{flip, geometry::Vec3::Zero()};
  system.poses.push_back(T_bal_world.inverse() * T_bal_camera);
}

// The file's observations are grouped by point (stably); no loss, no priors, unit weights.
inline adjustment::BundleSystem read_bal(const std::string& path) {
  std::ifstream in(path);
  std::size_t cameras = 0, points = 0, observations = 0;
  if (!(in >> cameras >> points >> observations)) throw std::runtime_error("not a BAL file: " + path);
  adjustment::BundleSystem system;
  system.loss = adjustment::BundleLoss::none;
  system.prior_loss_scale = 0.0;
  system.intrinsics = camera::IntrinsicsSet::radial;
  for (std::size_t i = 0; i < observations; ++i) {
    adjustment::BundleObservation o;
    in >> o.frame >> o.point >> o.pixel.x() >> o.pixel.y();
    o.pixel.y() = -o.pixel.y();
    system.observations.push_back(o);
  }
  std::stable_sort(system.observations.begin(), system.observations.end(),
                   [](const auto& a, const auto& b) { return a.point < b.point; });
  for (std::size_t i = 0; i < cameras; ++i) {
    BalCamera c{};
    in >> c.rotation[0] >> c.rotation[1] >> c.rotation[2] >> c.translation[0] >> c.translation[1] >> c.translation[2] >>
        c.f >> c.k1 >> c.k2;
    add_bal_camera(system, c);
  }
  for (std::size_t i = 0; i < points; ++i) {
    geometry::Vec3 p;
    in >> p.x() >> p.y() >> p.z();
    system.points.push_back(p);
  }
  if (!in) throw std::runtime_error("BAL file ends early: " + path);
  system.priors.resize(cameras);
  for (std::size_t i = 0; i < cameras; ++i) system.priors[i].pose = system.poses[i];
  return system;
}

// A level grid of photographs from 30 m with 0.5 px of noise and a start that is off by 0.003 rad, 0.1 m, 1 % of f and
// 0.2 m a point: 50 cameras and 20 000 points give about 209 000 observations.
inline adjustment::BundleSystem made_up_bal(std::size_t cameras, std::size_t points, std::uint64_t seed = 1) {
  base::Random random(seed, "bal", 0);
  const auto normal3 = [&](double sigma) {
    const double x = random.normal(), y = random.normal(), z = random.normal();
    return geometry::Vec3(sigma * x, sigma * y, sigma * z);
  };
  constexpr double kFocal = 2000.0;
  const auto side = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(cameras))));
  std::vector<geometry::Vec3> centres, turns, truth;
  for (std::size_t i = 0; i < cameras; ++i) {
    centres.push_back(geometry::Vec3(8.0 * static_cast<double>(i % side), 8.0 * static_cast<double>(i / side), 30.0) +
                      normal3(0.3));
    turns.push_back(normal3(0.05));
  }
  const double reach = 8.0 * static_cast<double>(side) + 2.0;
  for (std::size_t i = 0; i < points; ++i) {
    const double x = random.uniform(-10.0, reach), y = random.uniform(-10.0, reach);
    truth.emplace_back(x, y, 1.5 * random.normal());
  }
  adjustment::BundleSystem system;
  system.loss = adjustment::BundleLoss::none;
  system.prior_loss_scale = 0.0;
  system.intrinsics = camera::IntrinsicsSet::radial;
  for (const auto& p : truth) {
    std::vector<adjustment::BundleObservation> seen;
    for (std::size_t i = 0; i < cameras; ++i) {
      const geometry::Vec3 q = adjustment::exp_rotation(turns[i]) * (p - centres[i]);
      if (q.z() >= 0.0) continue;
      const double u = -kFocal * q.x() / q.z() + 0.5 * random.normal();
      const double v = -kFocal * q.y() / q.z() + 0.5 * random.normal();
      if (std::abs(u) >= 1500.0 || std::abs(v) >= 1000.0) continue;
      adjustment::BundleObservation o;
      o.frame = static_cast<std::int32_t>(i);
      o.point = static_cast<std::int32_t>(system.points.size());
      o.pixel = {u, -v};
      seen.push_back(o);
    }
    if (seen.size() < 3) continue;
    system.observations.insert(system.observations.end(), seen.begin(), seen.end());
    system.points.push_back(p + normal3(0.2));
  }
  for (std::size_t i = 0; i < cameras; ++i) {
    const geometry::Vec3 t = -(adjustment::exp_rotation(turns[i]) * centres[i]) + normal3(0.1);
    const geometry::Vec3 w = turns[i] + normal3(0.003);
    add_bal_camera(system, {{w.x(), w.y(), w.z()}, {t.x(), t.y(), t.z()}, kFocal * 1.01, 0.0, 0.0});
  }
  system.priors.resize(cameras);
  for (std::size_t i = 0; i < cameras; ++i) system.priors[i].pose = system.poses[i];
  return system;
}

}  // namespace cairn::testing
