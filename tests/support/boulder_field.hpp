// Rough sloping ground with half-buried boulders of known labels.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "base/random.hpp"
#include "geometry/vec.hpp"

namespace cairn::testing {

struct Boulder {
  geometry::Vec2 centre;
  double a, b, protrusion, yaw;  // semi-axes in plan, height above the ground, m; rad
};

struct BoulderField {
  std::vector<geometry::Vec3> points;
  std::vector<std::int32_t> boulder;  // of each point; -1: ground
  std::vector<Boulder> boulders;
  std::vector<double> amplitude, kx, ky, phase;  // of the ground's waves

  [[nodiscard]] double ground(double x, double y) const {
    double z = 0.1 * x;
    for (std::size_t i = 0; i < kx.size(); ++i) z += amplitude[i] * std::sin(kx[i] * x + ky[i] * y + phase[i]);
    return z;
  }
};

// side: of the square, m; waves of 40 m down to 0.5 m, steepness alike at all scales (slopes to about 30 deg); boulders
// of 0.3 to 1.2 m semi-axis, ellipsoids buried by a sixth, at least `gap` apart; 5 mm noise.
inline BoulderField boulder_field(std::uint64_t seed, std::size_t count, double side, std::size_t boulders,
                                  double gap = 0.5) {
  base::Random random(seed, "boulder_field", 0);
  BoulderField field;
  for (int i = 0; i < 40; ++i) {
    const double length = 40.0 * std::pow(0.5 / 40.0, random.uniform());
    const double direction = random.uniform(0.0, 6.283185307179586), k = 6.283185307179586 / length;
    field.kx.push_back(k * std::cos(direction));
    field.ky.push_back(k * std::sin(direction));
    field.amplitude.push_back(0.05 / k * std::pow(length / 40.0, 0.2));
    field.phase.push_back(random.uniform(0.0, 6.283185307179586));
  }
  while (field.boulders.size() < boulders) {
    const double a = 0.3 * std::pow(4.0, random.uniform());
    const geometry::Vec2 c(random.uniform(2.0, side - 2.0), random.uniform(2.0, side - 2.0));
    bool free = true;
    for (const Boulder& other : field.boulders) free &= (c - other.centre).norm() > a + other.a + gap;
    if (!free) continue;
    const double b = a * random.uniform(0.65, 1.0);
    field.boulders.push_back({c, a, b, std::max(0.25, a * random.uniform(0.6, 1.1)), random.uniform(0.0, 3.14159)});
  }
  for (std::size_t n = 0; n < count; ++n) {
    const double x = random.uniform(0.0, side), y = random.uniform(0.0, side);
    double z = field.ground(x, y);
    std::int32_t label = -1;
    for (std::size_t i = 0; i < field.boulders.size(); ++i) {
      const Boulder& s = field.boulders[i];
      const double dx = x - s.centre.x(), dy = y - s.centre.y();
      if (std::abs(dx) > s.a || std::abs(dy) > s.a) continue;
      const double u = (dx * std::cos(s.yaw) + dy * std::sin(s.yaw)) / s.a;
      const double v = (-dx * std::sin(s.yaw) + dy * std::cos(s.yaw)) / s.b;
      const double q = 1.0 - u * u - v * v;
      if (q <= 0.0) continue;
      const double top =
          field.ground(s.centre.x(), s.centre.y()) - 0.2 * s.protrusion + 1.2 * s.protrusion * std::sqrt(q);
      if (top < z + 0.01) continue;
      z = top;
      label = static_cast<std::int32_t>(i);
    }
    field.points.emplace_back(x, y, z + 0.005 * random.normal());
    field.boulder.push_back(label);
  }
  return field;
}

}  // namespace cairn::testing
