#include "simulation/noise.hpp"

#include <algorithm>
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

double fade_slope(double t) {
  return 30.0 * t * t * (t * (t - 2.0) + 1.0);
}

struct Cell {
  double corner[2][2][2];  // z, y, x
  double u, v, w;          // position inside, 0..1
};

Cell cell_at(const geometry::Vec3& p, std::uint64_t seed) {
  const double fx = std::floor(p.x()), fy = std::floor(p.y()), fz = std::floor(p.z());
  const auto x = static_cast<std::int64_t>(fx), y = static_cast<std::int64_t>(fy), z = static_cast<std::int64_t>(fz);
  Cell cell{};
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i) cell.corner[k][j][i] = lattice(x + i, y + j, z + k, seed);
  cell.u = p.x() - fx;
  cell.v = p.y() - fy;
  cell.w = p.z() - fz;
  return cell;
}

double plane(const double (&c)[2][2], double u, double v) {
  return mix(mix(c[0][0], c[0][1], u), mix(c[1][0], c[1][1], u), v);
}

// An orthogonal matrix of simple fractions (each row of norm 1) that maps no axis near another.
const geometry::Mat3& octave_turn() {
  static const geometry::Mat3 turn = [] {
    geometry::Mat3 m;
    m << 2.0, -2.0, 1.0, 1.0, 2.0, 2.0, -2.0, -1.0, 2.0;
    return geometry::Mat3(m / 3.0);
  }();
  return turn;
}

double carried(double wavelength, double footprint) {
  if (!(footprint > 0.0)) return 1.0;
  return std::clamp((wavelength / footprint - 0.8) / 0.8, 0.0, 1.0);
}

}  // namespace

double value_noise(const geometry::Vec3& p, std::uint64_t seed) {
  const Cell cell = cell_at(p, seed);
  const double u = fade(cell.u), v = fade(cell.v);
  return mix(plane(cell.corner[0], u, v), plane(cell.corner[1], u, v), fade(cell.w));
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

double filtered_noise(const geometry::Vec3& p, std::uint64_t seed, double wavelength, double footprint, int octaves,
                      double gain) {
  double sum = 0.0, total = 0.0, amplitude = 1.0, length = wavelength;
  geometry::Vec3 q = p;
  for (int i = 0; i < octaves; ++i) {
    total += amplitude;
    const double weight = carried(length, footprint);
    if (weight > 0.0) sum += weight * amplitude * value_noise(q / length, seed + static_cast<std::uint64_t>(i));
    amplitude *= gain;
    length *= 0.5;
    q = octave_turn() * q;
  }
  return sum / total;
}

geometry::Vec3 filtered_noise_gradient(const geometry::Vec3& p, std::uint64_t seed, double wavelength, double footprint,
                                       int octaves, double gain) {
  geometry::Vec3 sum = geometry::Vec3::Zero();
  double amplitude = 1.0, length = wavelength, total = 0.0;
  geometry::Mat3 turn = geometry::Mat3::Identity();
  for (int i = 0; i < octaves; ++i) {
    total += amplitude;
    if (const double weight = carried(length, footprint); weight > 0.0) {
      const Cell c = cell_at(turn * p / length, seed + static_cast<std::uint64_t>(i));
      const double u = fade(c.u), v = fade(c.v), w = fade(c.w);
      const auto along_x = [&](int k) {
        return mix(c.corner[k][0][1] - c.corner[k][0][0], c.corner[k][1][1] - c.corner[k][1][0], v);
      };
      const auto along_y = [&](int k) {
        return mix(c.corner[k][1][0] - c.corner[k][0][0], c.corner[k][1][1] - c.corner[k][0][1], u);
      };
      const geometry::Vec3 slope(fade_slope(c.u) * mix(along_x(0), along_x(1), w),
                                 fade_slope(c.v) * mix(along_y(0), along_y(1), w),
                                 fade_slope(c.w) * (plane(c.corner[1], u, v) - plane(c.corner[0], u, v)));
      sum += (weight * amplitude * wavelength / length) * (turn.transpose() * slope);
    }
    amplitude *= gain;
    length *= 0.5;
    turn = octave_turn() * turn;
  }
  return sum / total;
}

Stone stone_at(const geometry::Vec2& p, std::uint64_t seed, double cell, double share) {
  Stone best;
  const double fx = std::floor(p.x() / cell), fy = std::floor(p.y() / cell);
  for (int j = -1; j <= 1; ++j)
    for (int i = -1; i <= 1; ++i) {
      const auto x = static_cast<std::int64_t>(fx) + i, y = static_cast<std::int64_t>(fy) + j;
      const auto draw = [&](std::int64_t k) { return 0.5 + 0.5 * lattice(x, y, k, seed); };
      if (draw(0) >= share) continue;
      const double size = draw(3);
      const double radius = cell * (0.16 + 0.34 * size * size), squeeze = 0.6 + 0.4 * draw(4), turn = 3.1416 * draw(5);
      const geometry::Vec2 middle(cell * (static_cast<double>(x) + draw(1)), cell * (static_cast<double>(y) + draw(2)));
      const geometry::Vec2 d = p - middle;
      const double c = std::cos(turn), s = std::sin(turn);
      const double u = (c * d.x() + s * d.y()) / radius, v = (c * d.y() - s * d.x()) / (squeeze * radius);
      const double out = u * u + v * v, height = 1.0 - out;
      if (height <= best.height) continue;
      best.height = height;
      best.slope = geometry::Vec2(c * u - s * v / squeeze, s * u + c * v / squeeze);
      best.shade = lattice(x, y, 6, seed);
    }
  return best;
}

}  // namespace cairn::simulation
