#include "simulation/shape.hpp"

#include <cmath>
#include <numbers>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "geometry/mass_properties.hpp"
#include "geometry/rigid_transform.hpp"
#include "simulation/noise.hpp"

namespace cairn::simulation {

Shape make_shape(const ShapeSpec& spec, base::Random& random) {
  constexpr std::uint32_t rings = 24, around = 48;
  Shape shape;
  auto& mesh = shape.body;
  const std::uint64_t seed = random.bits();
  const geometry::Vec3 half = 0.5 * spec.size_m;
  for (std::uint32_t i = 1; i < rings; ++i)
    for (std::uint32_t j = 0; j < around; ++j) {
      const double a = std::numbers::pi * i / rings, b = 2.0 * std::numbers::pi * j / around;
      const geometry::Vec3 d(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a));
      const double bump =
          spec.kind == ShapeKind::rock ? 1.0 + 0.4 * spec.irregularity * fractal_noise(2.0 * d, seed, 3) : 1.0;
      mesh.vertices.push_back(bump * d.cwiseProduct(half));
    }
  mesh.vertices.push_back({0, 0, half.z()});
  mesh.vertices.push_back({0, 0, -half.z()});
  const std::uint32_t top = (rings - 1) * around, bottom = top + 1;
  for (std::uint32_t j = 0; j < around; ++j) {
    const std::uint32_t next = (j + 1) % around;
    mesh.triangles.push_back({top, j, next});
    mesh.triangles.push_back({bottom, (rings - 2) * around + next, (rings - 2) * around + j});
    for (std::uint32_t i = 0; i + 2 < rings; ++i) {
      const std::uint32_t a = i * around + j, b = i * around + next, c = a + around, d = b + around;
      mesh.triangles.push_back({a, c, d});
      mesh.triangles.push_back({a, d, b});
    }
  }
  const auto turn = geometry::axis_rotation(geometry::Vec3::UnitZ(), base::deg_to_rad(90.0 - spec.azimuth_deg));
  for (auto& v : mesh.vertices) v = turn * v + geometry::Vec3(0, 0, half.z() + spec.pedestal_height_m);
  const auto mass = geometry::mass_properties(mesh);
  shape.volume_m3 = mass.volume;
  shape.centre_of_mass = mass.centre_of_mass;
  return shape;
}

}  // namespace cairn::simulation
