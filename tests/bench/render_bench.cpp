// Renders a field of boulders, trees and cones: prints pixels a CPU second; with a folder, writes what it saw.
//   bench_render [WIDTH [SAMPLES [FOLDER]]]
#include <Eigen/Geometry>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "base/random.hpp"
#include "bench/cpu_clock.hpp"
#include "geometry/rigid_transform.hpp"
#include "io/image.hpp"
#include "simulation/noise.hpp"
#include "simulation/render.hpp"
#include "simulation/shape.hpp"

namespace {

using namespace cairn;
using geometry::Vec3;
using simulation::RenderBody;

double ground(double x, double y) {
  return 1.1 * simulation::fractal_noise({x / 14.0, y / 14.0, 0.3}, 5, 2) +
         0.16 * simulation::fractal_noise({x / 1.6, y / 1.6, 0.7}, 6, 4);
}

geometry::TriangleMesh terrain(double half, double cell) {
  geometry::TriangleMesh mesh;
  const auto n = static_cast<std::uint32_t>(2.0 * half / cell);
  for (std::uint32_t j = 0; j <= n; ++j)
    for (std::uint32_t i = 0; i <= n; ++i) {
      const double x = -half + cell * i, y = -half + cell * j;
      mesh.vertices.emplace_back(x, y, ground(x, y));
    }
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t a = j * (n + 1) + i;
      mesh.triangles.push_back({a, a + 1, a + n + 2});
      mesh.triangles.push_back({a, a + n + 2, a + n + 1});
    }
  return mesh;
}

class World {
 public:
  void add(const simulation::ShapeSpec& spec, double x, double y, const std::string& material, bool rock) {
    base::Random random(3, "world", static_cast<std::uint64_t>(next_));
    auto shape = simulation::make_shape(spec, random);
    const Vec3 foot(x, y, ground(x, y) - (spec.pedestal_height_m > 0.0 ? 0.0 : 0.06));
    for (auto* mesh : {&shape.body, &shape.pedestal})
      for (Vec3& v : mesh->vertices) v += foot;
    RenderBody body;
    body.material = simulation::material_named(material, static_cast<std::uint64_t>(next_) * 977).value();
    body.part = rock ? simulation::SurfacePart::rock : simulation::SurfacePart::other;
    body.object = next_++;
    if (!shape.pedestal.triangles.empty()) {
      RenderBody pedestal = body;
      pedestal.mesh = shape.pedestal;
      pedestal.part = simulation::SurfacePart::pedestal;
      bodies.push_back(pedestal);
    }
    body.mesh = std::move(shape.body);
    bodies.push_back(std::move(body));
  }
  std::vector<RenderBody> bodies;

 private:
  std::int64_t next_ = 0;
};

geometry::RigidTransform looking(const Vec3& from, const Vec3& at) {
  const Vec3 forward = (at - from).normalized();
  const Vec3 right = forward.cross(Vec3::UnitZ()).normalized();
  geometry::RigidTransform pose;
  pose.rotation.col(0) = right;
  pose.rotation.col(1) = forward.cross(right);
  pose.rotation.col(2) = forward;
  pose.translation = from;
  return pose;
}

void report(const std::string& name, const simulation::RenderScene& scene, const survey::Camera& camera,
            const geometry::RigidTransform& pose, const simulation::RenderOptions& options, const std::string& folder) {
  const double start = bench::cpu_seconds();
  const auto frame = simulation::render(scene, camera, pose, options, 1, 1);
  const double spent = bench::cpu_seconds() - start, pixels = static_cast<double>(camera.width_px * camera.height_px);
  std::printf("%s: %.0f pixels, %lld^2 samples, %.2f CPU s, %.3f Mpixel/CPU s\n", name.c_str(), pixels,
              static_cast<long long>(options.samples), spent, 1e-6 * pixels / spent);
  if (folder.empty()) return;
  io::write_rgb_image(folder + "/" + name + ".png", camera.width_px, camera.height_px, frame.rgb);
  io::write_grey16_png(folder + "/" + name + "_depth.png", camera.width_px, camera.height_px,
                       simulation::depth_millimetres(frame));
}

}  // namespace

int main(int argc, char** argv) {
  const std::int64_t width = argc > 1 ? std::atoll(argv[1]) : 1280;
  simulation::RenderOptions options;
  options.samples = argc > 2 ? std::atoll(argv[2]) : 2;
  const std::string folder = argc > 3 ? argv[3] : "";

  World world;
  RenderBody earth;
  earth.mesh = terrain(45.0, 0.18);
  earth.material = *simulation::material_named("soil", 9);
  earth.part = simulation::SurfacePart::terrain;
  world.bodies.push_back(std::move(earth));
  const auto& families = simulation::rock_families();
  base::Random place(8, "places", 0);
  for (std::size_t k = 0; k < 5; ++k) {
    simulation::ShapeSpec spec;
    spec.family = families[k];
    spec.size_m = Vec3(1.7, 1.4, k == 2 ? 1.0 : 2.0);
    spec.azimuth_deg = 40.0 * static_cast<double>(k);
    spec.pedestal_height_m = 0.7;
    spec.pedestal_radius_m = 0.75;
    spec.contact_share = 0.5;
    spec.irregularity = 0.5;
    spec.edge_m = 0.03;
    world.add(spec, -8.0 + 4.0 * static_cast<double>(k), 2.0 * std::sin(2.0 * static_cast<double>(k)), "granite", true);
  }
  for (int k = 0; k < 60; ++k) {
    simulation::ShapeSpec spec;
    const double size = place.uniform(0.25, 1.1);
    spec.size_m = Vec3(size, size * place.uniform(0.7, 1.0), size * place.uniform(0.5, 0.9));
    spec.azimuth_deg = place.uniform(0.0, 360.0);
    spec.foot_share = 0.85;
    spec.edge_m = 0.03;
    spec.irregularity = place.uniform(0.3, 0.9);
    spec.family = k % 3 == 0 ? "rounded" : k % 3 == 1 ? "angular" : "slab";
    const double x = place.uniform(-18.0, 18.0), y = place.uniform(-8.0, 22.0);
    world.add(spec, x, y, "granite", false);
  }
  for (int k = 0; k < 26; ++k) {
    simulation::ShapeSpec spec;
    spec.kind = simulation::ShapeKind::tree;
    const bool bush = k % 2 == 1;
    spec.family = bush ? "bush" : k % 4 == 0 ? "conifer" : "broadleaf";
    const double height = bush ? place.uniform(0.5, 1.1) : place.uniform(2.5, 5.0);
    spec.size_m = Vec3(bush ? 1.3 * height : 0.7 * height, bush ? 1.2 * height : 0.7 * height, height);
    spec.azimuth_deg = place.uniform(0.0, 360.0);
    spec.edge_m = 0.07;
    const double x = place.uniform(-24.0, 24.0), y = bush ? place.uniform(-7.0, 24.0) : place.uniform(7.0, 34.0);
    world.add(spec, x, y, "foliage", false);
  }
  for (int k = 0; k < 4; ++k) {
    simulation::ShapeSpec spec;
    spec.kind = simulation::ShapeKind::cone;
    spec.size_m = Vec3(0.38, 0.38, 0.7);
    world.add(spec, -4.0 + 2.6 * k, -4.6 + 0.4 * k, "paint", false);
  }
  const double start = bench::cpu_seconds();
  const simulation::RenderScene scene(std::move(world.bodies), {});
  std::printf("scene: %zu triangles, %.2f CPU s, %.0f MB\n", scene.mesh().triangles.size(),
              bench::cpu_seconds() - start, bench::peak_megabytes());

  survey::Camera camera;
  camera.width_px = width;
  camera.height_px = width * 9 / 16;
  camera.fx_px = camera.fy_px = 0.9 * static_cast<double>(width);
  camera.cx_px = 0.5 * static_cast<double>(width);
  camera.cy_px = 0.5 * static_cast<double>(camera.height_px);
  report("field", scene, camera, looking({-6.0, -13.0, 6.0}, {0.0, 1.0, 0.6}), options, folder);
  report("rock", scene, camera, looking({-3.0, -4.0, 2.6}, {-0.2, 1.9, 1.5}), options, folder);
  report("slabrock", scene, camera, looking({-1.5, -4.0, 2.0}, {0.0, -1.2, 1.2}), options, folder);
  report("nadir", scene, camera, looking({0.1, 0.0, 22.0}, {0.0, 0.3, 0.0}), options, folder);
}
