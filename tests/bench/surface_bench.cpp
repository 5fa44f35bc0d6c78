// Closed mesh of a rock, from points alone: bench_surface [FILE.ply [EVERY_NTH]].
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "base/random.hpp"
#include "geometry/mass_properties.hpp"
#include "io/ply.hpp"
#include "surface/implicit_surface.hpp"
#include "surface/mesh_checks.hpp"

namespace {

using cairn::geometry::Vec3;

double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

// Ellipsoid with 1 mm of noise, where no file is given.
std::vector<Vec3> drawn() {
  cairn::base::Random random(5, "bench_surface", 0);
  std::vector<Vec3> points;
  for (int i = 0; i < 200000; ++i) {
    const Vec3 d = Vec3(random.normal(), random.normal(), random.normal()).normalized();
    const double r = 1.0 / d.cwiseQuotient(Vec3(1.0, 0.75, 0.55)).norm();
    points.push_back(r * d + 0.001 * Vec3(random.normal(), random.normal(), random.normal()));
  }
  return points;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<Vec3> points = argc > 1 ? cairn::io::read_ply_cloud(argv[1]).cloud.positions : drawn();
  const std::size_t every = argc > 2 ? static_cast<std::size_t>(std::max(1, std::atoi(argv[2]))) : 1;
  std::vector<Vec3> some;
  for (std::size_t i = 0; i < points.size(); i += every) some.push_back(points[i]);
  const double start = cpu_seconds();
  const double spacing = cairn::surface::surface_spacing(some);
  const auto made = cairn::surface::implicit_surface(some, {}, spacing, {});
  const double built = cpu_seconds();
  const auto topology = cairn::geometry::topology(made.surface.mesh);
  const bool crossing = cairn::surface::self_intersects(made.surface.mesh);
  const double checked = cpu_seconds();
  const auto mass = cairn::geometry::mass_properties(made.surface.mesh);
  std::printf("points %zu, spacing %.4f m, noise %.5f m, triangles %zu\n", some.size(), spacing, made.noise,
              made.surface.mesh.triangles.size());
  std::printf("volume %.9f m3, closed %s, pieces %zu, passes through itself %s\n", mass.volume,
              topology.closed() ? "yes" : "no", topology.components, crossing ? "yes" : "no");
  std::printf("CPU s: surface %.2f, checks %.2f\n", built - start, checked - built);
  return 0;
}
