// Seeded noise in space: the same value at the same point, whoever asks.
#pragma once

#include <cstdint>

#include "geometry/vec.hpp"

namespace cairn::simulation {

// Trilinear value noise on the integer lattice with quintic fade (Perlin 2002, "Improving noise", the fade):
// -1..1, continuous second derivatives, features of about one unit.
[[nodiscard]] double value_noise(const geometry::Vec3& p, std::uint64_t seed);

// Sum of `octaves` of value noise, each of twice the frequency and `gain` times the amplitude of the last, over
// the sum of amplitudes: -1..1.
[[nodiscard]] double fractal_noise(const geometry::Vec3& p, std::uint64_t seed, int octaves, double gain = 0.5);

}  // namespace cairn::simulation
