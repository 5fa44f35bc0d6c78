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
// pixel [m] cannot carry (they fade out between 1.6 and 0.8 pixels a feature). Each octave is turned
// against the last, so that the lattice does not show.
[[nodiscard]] double filtered_noise(const geometry::Vec3& p, std::uint64_t seed, double wavelength, double footprint,
                                    int octaves, double gain = 0.5);

// Gradient of the field above, per wavelength of its first octave, all octaves that the footprint carries.
[[nodiscard]] geometry::Vec3 filtered_noise_gradient(const geometry::Vec3& p, std::uint64_t seed, double wavelength,
                                                     double footprint, int octaves, double gain = 0.5);

// Stones strewn over the plan: at most one in each square cell, of 0.16 to 0.5 cells' radius.
struct Stone {
  double height = 0.0;                            // 1 in the middle of a stone .. 0 at its edge and outside
  geometry::Vec2 slope = geometry::Vec2::Zero();  // outward, length 1 at the edge
  double shade = 0.0;                             // -1..1, one value a stone
};
// The highest stone over a point of the plan [m]; `share` of the cells hold one.
[[nodiscard]] Stone stone_at(const geometry::Vec2& p, std::uint64_t seed, double cell, double share);

}  // namespace cairn::simulation
