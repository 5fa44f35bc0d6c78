// What rocks: the toes that a rigid body pivots about, in order of rotation, and what an impact between them keeps.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "fragility/tipping.hpp"
#include "geometry/mass_properties.hpp"
#include "geometry/vec.hpp"

namespace cairn::fragility {

// One axis of rotation. Angles are rotations theta from the pose of rest, positive towards +u (the direction of the
// profile), negative towards -u.
struct Toe {
  double alpha = 0.0;        // theta at which the centre of mass stands above the axis, rad
  double p_squared = 0.0;    // g R cos(delta) m / I, rad^2/s^2, > 0
  double gain = 1.0;         // (u . edge normal) / cos(delta): how much of the horizontal acceleration acts; 1 if level
  double eta_from_up = 1.0;  // angular velocity kept when the pivot comes here from the next toe (theta falling)
  double eta_from_down = 1.0;  // likewise from the toe before (theta rising)
};

// A body seen in one vertical plane. At theta = switches[i] the body lies on toes i and i + 1 together.
struct RockingProfile {
  std::vector<Toe> toes;         // two or more, by the rotation at which each carries the body, ascending
  std::vector<double> switches;  // one less than toes, rad, ascending
  std::size_t rest = 0;          // switches[rest] = 0: the pose of rest
};

// Throws invalid_argument unless the sizes fit, switches ascend, switches[rest] = 0 and the rest is stable
// (alpha of toe rest < 0 < alpha of toe rest + 1).
void validate(const RockingProfile& profile);

// theta of the highest potential on each side, within 90 degrees: beyond it the body falls on by itself.
struct TopplingAngles {
  double down = 0.0;  // rad, < 0
  double up = 0.0;    // rad, > 0
};
[[nodiscard]] TopplingAngles toppling_angles(const RockingProfile& profile);

// Two toes in a vertical plane (fragility.md 1.1, 2.2): horizontal distances b_up (towards +u), b_down (towards -u)
// and heights h_up, h_down of the centre of mass above the toes, all m > 0; inertia about the centre of mass / mass
// [m^2]. eta = (I_cm/m + h_up h_down - b_up b_down) / (I_cm/m + R^2 of the new toe), from the angular momentum about
// the new toe.
[[nodiscard]] RockingProfile two_toe_profile(double b_up, double h_up, double b_down, double h_down,
                                             double inertia_per_mass);

// A block of half width b and half height h: Housner's rectangle.
[[nodiscard]] RockingProfile rectangle_profile(double half_width, double half_height);

// The two edges of the support that a motion along `azimuth_deg` (clockwise from +y, theta > 0 topples towards it)
// tips about: those that the rays from the plumb point towards the azimuth and against it leave by. Edges may be
// inclined and need not be parallel: an impact keeps the angular momentum about the new edge,
//   eta = [t2 . I_cm t1 + m (t2 x r2) . (t1 x r1)] / I_2.
// result: of tipping(), stable. Empty where an edge stands too steep to tip about (alpha >= pi/2).
[[nodiscard]] std::optional<RockingProfile> edge_profile(const TippingResult& result,
                                                         const geometry::MassProperties& mass, double azimuth_deg);

// A convex body that rolls on a level plane without slip: the section of its hull by the vertical plane through the
// centre of mass along `azimuth_deg`; every corner of its lower side is a toe. `pose` must stand at rest: the lowest
// facet of the hull below the centre of mass (see resting_pose). Points: of the body, m, z up.
// Empty where the plumb point lies outside the section's lowest side.
[[nodiscard]] std::optional<RockingProfile> hull_profile(std::span<const geometry::Vec3> points,
                                                         const geometry::MassProperties& mass, double azimuth_deg);

// Energy kept at a passage there and back is eta_from_up eta_from_down (one eta alone may exceed 1: a nearer toe makes
// the body turn faster). Impacts on uneven contacts lose less than angular momentum about a point says: of what each
// pair loses, `share` (0..1) is given back; 0 leaves the geometry's.
[[nodiscard]] RockingProfile with_restitution(RockingProfile profile, double share);
// Or the same energy for every pair: eta_from_up eta_from_down = eta^2, eta in 0..1.
[[nodiscard]] RockingProfile with_fixed_restitution(RockingProfile profile, double eta);

}  // namespace cairn::fragility
