// One rock: tipping and grade together, so that no number leaves without its grade.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "base/random.hpp"
#include "fragility/contact_line.hpp"
#include "fragility/grade.hpp"
#include "fragility/monte_carlo.hpp"
#include "fragility/tipping.hpp"
#include "geometry/mass_properties.hpp"
#include "geometry/triangle_mesh.hpp"
#include "survey/rock.hpp"

namespace cairn::fragility {

struct FragilityOptions {
  double density_kg_m3 = 2600.0;  // granite 2500-2800; alpha, R, p and v_min do not depend on it
  // Friction coefficient rock on rock: where tan(alpha) exceeds it, the rock slides before it topples.
  double friction = 0.65;
  // Without a contact: the mesh's points within this share of its height above its lowest point.
  double contact_band = 0.02;
  double plumb_tolerance_m = 1e-4;  // plumb points closer to the polygon's border count as outside
  double pedestal_curvature = 0.0;  // 1/m, under a single contact point: convex > 0, 0 = flat
  GradeOptions grade;
  MonteCarloOptions monte_carlo;

  void visit(base::OptionVisitor& visitor);
};

// The assumed contact: vertices of the mesh within `band` x height of its lowest vertex.
// This is the outer rim of whatever closes the base, so the alpha it gives is an upper bound.
[[nodiscard]] std::vector<geometry::Vec3> contact_band(const geometry::TriangleMesh& mesh, double band);

// What is known of one rock.
struct Subject {
  const geometry::TriangleMesh* mesh = nullptr;  // closed, outward, m, z true vertical; nullptr = mass only
  geometry::MassProperties mass;                 // of it, unit density
  std::vector<ContactVertex> contact;            // sorted; the rim, or what was assumed
  Evidence evidence;
  std::span<const std::uint8_t> seen;  // a flag a triangle of the mesh; empty = not known
  double noise_m = 0.0;                // of the points about the mesh; 0 = not known
  double cap_height_sigma_m = 0.0;     // 0 = not known
  double density_kg_m3 = 2600.0;
};

struct Assessment {
  survey::Tipping tipping;
  // All edges and the polar table; empty when the grade is not_measurable, so nothing can print them.
  TippingResult detail;
  std::vector<TippingDraw> draws;  // empty likewise, and without draws
};

// Grade from the evidence and from equilibrium: a contact that cannot hold the rock up gives not_measurable with its
// reason code. Every number of alpha, R, p, a_qs and v_min is left out of all results then. Further reasons:
// `slides_first` where tan(alpha) > friction; `equilibrium_uncertain` where more than a twentieth of the draws do not
// stand; after `point_contact` one of `rolls_back` (stable on the point), `rolls_away`, or none where the mesh is too
// coarse to tell. random(k): generator of Monte Carlo draw k (monte_carlo.hpp).
[[nodiscard]] Assessment assess(const Subject& subject, const FragilityOptions& options,
                                const std::function<base::Random(std::uint64_t)>& random);

}  // namespace cairn::fragility
