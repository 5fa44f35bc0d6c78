// One rock: tipping and grade together, so that no number leaves without its grade.
#pragma once

#include <span>
#include <vector>

#include "fragility/grade.hpp"
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
  GradeOptions grade;

  void visit(base::OptionVisitor& visitor);
};

// The assumed contact: vertices of the mesh within `band` x height of its lowest vertex.
// This is the outer rim of whatever closes the base, so the alpha it gives is an upper bound.
[[nodiscard]] std::vector<geometry::Vec3> contact_band(const geometry::TriangleMesh& mesh, double band);

struct Assessment {
  survey::Tipping tipping;
  // All edges and the polar table; empty when the grade is not_measurable, so nothing can print them.
  TippingResult detail;
};

// Grade from the evidence and from equilibrium: a contact that cannot hold the rock up gives
// not_measurable with its reason code. Every number of alpha, R, p, a_qs and v_min is left
// out of both results then. sliding: reason `slides_first` where tan(alpha) > friction.
[[nodiscard]] Assessment assess(const geometry::MassProperties& mass, std::span<const geometry::Vec3> contacts,
                                const Evidence& evidence, const FragilityOptions& options);

}  // namespace cairn::fragility
