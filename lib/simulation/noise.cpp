#include "simulation/noise.hpp"

#include <cmath>

namespace cairn::simulation {
namespace {

// SplitMix64's finaliser over the lattice point.
double lattice(std::int64_t x, std::int64_t y, std::int64_t z, std::uint64_t seed) {
  std::uint64_t h = seed + 0x9e3779b97f4a7c15ULL * static_cast<std::uint64_t>(x);
  h = (h ^ (h >> 32U)) * 0xd6e8feb86659fd93ULL + 0xbf58476d1ce4e5b9ULL * static_cast<std::uint64_t>(y);
  h = (h ^ (h >> 29U)) * 0x94d049bb133111ebULL + 0x2545f4914f6cdd1dULL * static_cast<std::uint64_t>(z);
  h = (h ^ (h >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  h ^= h >> 27U;
  h *= 0x94d049bb133111ebULL;
  return static_cast<double>(h >> 11U) * 0x1.0p-52 - 1.0;
}

double fade(double t) {
  return t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
}

double mix(double a, double b, double t) {
  return a + (b - a) * t;
}

}  // namespace

double value_noise(const geometry::Vec3& p, std::uint64_t seed) {
  const double fx = std::floor(p.x()), fy = std::floor(p.y()), fz = std::floor(p.z());
  const auto x = static_cast<std::int64_t>(fx), y = static_cast<std::int64_t>(fy), z = static_cast<std::int64_t>(fz);
  const double u = fade(p.x() - fx), v = fade(p.y() - fy), w = fade(p.z() - fz);
  const auto plane = [&](std::int64_t k) {
    return mix(mix(lattice(x, y, k, seed), lattice(x + 1, y, k, seed), u),
               mix(lattice(x, y + 1, k, seed), lattice(x + 1, y + 1, k, seed), u), v);
  };
  return mix(plane(z), plane(z + 1), w);
}

double fractal_noise(const geometry::Vec3& p, std::uint64_t seed, int octaves, double gain) {
  double sum = 0.0, total = 0.0, amplitude = 1.0;
  geometry::Vec3 q = p;
  for (int i = 0; i < octaves; ++i) {
    sum += amplitude * value_noise(q, seed + static_cast<std::uint64_t>(i));
    total += amplitude;
    amplitude *= gain;
    q *= 2.0;
  }
  return total > 0.0 ? sum / total : 0.0;
}

}  // namespace cairn::simulation
