// The outline of generated rocks: a distance from an inner point in every direction.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "base/random.hpp"
#include "geometry/vec.hpp"

namespace cairn::simulation {

// Star-shaped about the origin, about two units across. Forms by family:
//   rounded  ball under low-frequency noise (core stone)
//   angular  intersection of 14 to 22 half-spaces, edges slightly blunted (joint block)
//   slab     few half-spaces near a flat box, cut by bedding grooves
//   pear     wide head blended into a narrow foot
//   stacked  two flattened lumps, the upper off centre, with a neck between them
class RockForm {
 public:
  RockForm(std::string_view family, double irregularity, base::Random& random);

  // Distance from the origin to the surface along a unit direction, > 0.
  [[nodiscard]] double radius(const geometry::Vec3& direction) const;

 private:
  struct HalfSpace {
    geometry::Vec3 normal;
    double distance;
  };
  struct Ball {
    geometry::Vec3 centre, semi_axes;
  };
  [[nodiscard]] double blunt_polyhedron(const geometry::Vec3& direction) const;
  [[nodiscard]] double blended_balls(const geometry::Vec3& direction) const;

  std::vector<HalfSpace> faces_;  // either these
  std::vector<Ball> balls_;       // or these, each containing the origin
  double sharpness_ = 12.0;       // exponent of the blunted edges
  double swell_ = 0.0, swell_frequency_ = 1.0;
  double roughness_ = 0.0;
  double groove_depth_ = 0.0, groove_spacing_ = 1.0, groove_phase_ = 0.0;
  std::uint64_t seed_ = 0;
};

}  // namespace cairn::simulation
