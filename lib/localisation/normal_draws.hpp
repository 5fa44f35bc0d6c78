// Standard normal numbers by the thousand.
#pragma once

#include <span>

#include "base/random.hpp"

namespace cairn::localisation {

// Fills with independent standard normals (ziggurat of Marsaglia and Tsang 2000, 256 layers, the tail
// exact), about five times faster than base::Random::normal(), which the points update needs.
void fill_normal(std::span<double> out, base::Random& random);

}  // namespace cairn::localisation
