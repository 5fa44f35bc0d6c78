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

// The same sum for features of `wavelength` [m] and finer at a point [m], without octaves that the `footprint` of a
// pixel [m] cannot carry (they fade out between three and one and a half pixels a feature). Each octave is turned
// against the last, so that the lattice does not show.
[[nodiscard]] double filtered_noise(const geometry::Vec3& p, std::uint64_t seed, double wavelength, double footprint,
                                    int octaves, double gain = 0.5);

// Gradient of the field above, per wavelength of its first octave, all octaves that the footprint carries.
[[nodiscard]] geometry::Vec3 filtered_noise_gradient(const geometry::Vec3& p, std::uint64_t seed, double wavelength,
                                                     double footprint, int octaves, double gain = 0.5);

}  // namespace cairn::simulation
