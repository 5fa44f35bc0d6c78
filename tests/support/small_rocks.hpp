// A small made-up site for the commands around rocks: a cloud and its targets.json.
#pragma once

#include <cmath>
#include <filesystem>

#include "base/random.hpp"
#include "io/cloud.hpp"
#include "io/targets_json.hpp"

namespace cairn::testing {

// A lawn of 12 x 12 m in the local frame. Rock 1: half-ellipsoid seen from above, about 90 points per m2 (sparse). Rock
// 2: cylinder of 0.5 m radius and 1.2 m height, scanned all round at 2 cm. Target 3 stands on bare lawn, target 4 is a
// tree, target 5 lies outside the cloud.
inline void write_small_rocks(const std::filesystem::path& folder) {
  base::Random random(31, "small_rocks", 0);
  geometry::PointCloud cloud;
  const geometry::Vec2 dome(-3, 0), post(3, 0);
  for (int i = 0; i < 144 * 90; ++i) {
    const geometry::Vec2 p(random.uniform(-6, 6), random.uniform(-6, 6));
    if ((p - post).norm() < 0.5) continue;
    const geometry::Vec2 d = p - dome;
    const double q = d.x() * d.x() / .25 + d.y() * d.y() / .16;
    cloud.positions.emplace_back(p.x(), p.y(), 20 + (q < 1 ? .35 * std::sqrt(1 - q) : 0.0) + 0.005 * random.normal());
  }
  const int wall = 9400, top = 1960;
  for (int i = 0; i < wall + top; ++i) {
    const double a = random.uniform(0, 6.283185307179586);
    const double r = i < wall ? 0.5 : 0.5 * std::sqrt(random.uniform());
    const double z = i < wall ? random.uniform(0.0, 1.2) : 1.2;
    cloud.positions.emplace_back(post.x() + r * std::cos(a), post.y() + r * std::sin(a), 20 + z);
  }
  io::CloudWriteOptions write;
  io::write_cloud(folder / "cloud.las", cloud, write);

  io::TargetsFile file;
  file.frame.position = {46.8426, -91.994, 158.0};
  file.frame.height_type = survey::HeightType::ellipsoidal;
  const auto add = [&file](std::int64_t id, const char* object_class, const geometry::Vec3& centre, double radius) {
    survey::Target t;
    t.id = survey::TargetId(id);
    t.object_class = object_class;
    t.state = survey::TargetState::mapped;
    t.centre = centre;
    t.covariance = geometry::Mat3::Identity() * 1e-4;
    t.bcylinder = geometry::VerticalCylinder{centre.head<2>(), centre.z() - 0.5, centre.z() + 0.5, radius};
    file.targets.push_back(t);
  };
  add(1, "boulder", {-3.02, 0.01, 20.2}, .5);
  add(2, "boulder", {3.0, 0.02, 20.6}, .55);
  add(3, "boulder", {0, 4, 20}, .5);
  add(4, "tree", {0, -4, 22}, 1);
  add(5, "boulder", {90, 0, 20}, .5);
  io::write_targets(folder / "targets.json", file);
}

}  // namespace cairn::testing
