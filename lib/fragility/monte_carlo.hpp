// Tipping under uncertainty: seeded draws of contact, cap, surface, density, vertical and scale.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/options.hpp"
#include "base/random.hpp"
#include "fragility/contact_line.hpp"
#include "geometry/mass_properties.hpp"
#include "geometry/triangle_mesh.hpp"
#include "survey/rock.hpp"

namespace cairn::fragility {

struct MonteCarloOptions {
  std::int64_t draws = 1000;            // 0 = no draws
  std::int64_t share_draws = 250;       // of each source alone, for the shares of the variance; 0 = none
  double contact_sigma_m = 0.0;         // across the line where it states none; 0 = from spacing, noise and size
  double contact_correlation_m = 0.15;  // along the line: an error reaches this far
  double contact_common_share = 0.5;    // of its variance: the same all round a pad
  double contact_vertical_share = 0.5;  // vertical error of the line / error across it in plan
  double inferred_sigma_share = 0.5;    // added where the line was not seen: this share of the distance to where it was
  double bearing_inset_max = 0.5;  // hidden bearing: drawn in from the rim by 0 .. this share of the radius, uniform
  double cap_sigma_m = 0.0;        // height of the base's middle; 0 = what the surface stage stated, else by the next
  double cap_sigma_share = 0.05;   // of the contact's mean radius
  double surface_sigma_m = 0.0;    // error of the surface over a patch; 0 = half the points' noise, if known
  double surface_offset_share = 0.3;   // of that: the whole surface too large or too small
  double surface_correlation_m = 0.2;  // size of a patch
  double unseen_sigma_share = 0.05;    // error of a surface that no point supports / mean radius of the rock
  double density_sigma = 0.04;         // relative
  double density_gradient = 0.02;      // relative change over one radius of gyration: rind, voids; each axis
  double vertical_sigma_deg = 0.2;     // tilt of the survey's vertical, each of two axes
  double scale_sigma = 0.002;          // relative

  void visit(base::OptionVisitor& visitor);
};

// What the draws start from.
struct MonteCarloInput {
  const geometry::TriangleMesh* mesh = nullptr;  // closed, outward; nullptr: the surface has no error
  geometry::MassProperties mass;
  std::span<const std::uint8_t> seen;  // a flag a triangle of the mesh; empty = not known
  double unseen_area_fraction = 0.0;   // used where `seen` is empty
  std::vector<ContactVertex> contact;  // sorted; the rim
  double point_spacing_m = 0.0;        // 0 = not known
  double noise_m = 0.0;                // of the points about the mesh; 0 = not known
  double cap_height_sigma_m = 0.0;     // 0 = not known
  double density_kg_m3 = 2600.0;
  double plumb_tolerance_m = 1e-4;
  double friction = 0.65;
};

// One draw. Angles in rad; where it does not stand all that follows from alpha is 0.
struct TippingDraw {
  bool standing = false;
  double alpha = 0.0, azimuth_deg = 0.0, r = 0.0, p = 0.0, a_qs_g = 0.0, v_min = 0.0, barrier_j = 0.0;
  // About the edge it rocks back on, opposite to the critical one.
  double opposite_alpha = 0.0, opposite_r = 0.0, opposite_p = 0.0;
  std::optional<double> alpha_bearing;  // on the hidden bearing contact; empty where that cannot hold the rock
  double bearing_inset = 0.0;           // 0..1
  geometry::MassProperties mass;        // unit density
  double density_kg_m3 = 0.0;
};

struct MonteCarloResult {
  std::vector<TippingDraw> draws;
  survey::TippingUncertainty summary;  // draws_file left empty
  std::vector<double> critical_share;  // a value an edge given
};

// random(k): generator of draw k; the same k always gives the same numbers. So neither threads nor the count of draws
// change a draw. edge_azimuths_deg: of the nominal edges, for the share of draws in which each is critical (by nearest
// azimuth); nominal_azimuth_deg: of the critical one, about which azimuths are unwrapped.
// The mass answers to the surface's displacements to first order (surface_moments.hpp). Cost per draw: contact vertices
// x knots + 360 x hull edges; the line is taken at no more than 160 vertices.
[[nodiscard]] MonteCarloResult tipping_draws(const MonteCarloInput& input, const MonteCarloOptions& options,
                                             const std::function<base::Random(std::uint64_t)>& random,
                                             std::span<const double> edge_azimuths_deg, double nominal_azimuth_deg);

// Standard deviation of each vertex across the line, m: the stated one, else by the options; see
// docs/science/tipping.md.
[[nodiscard]] std::vector<double> contact_sigmas(const MonteCarloInput& input, const MonteCarloOptions& options);

}  // namespace cairn::fragility
