// Quasi-static tipping of a rigid rock on its contact points: every push azimuth, every edge.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "geometry/mass_properties.hpp"
#include "geometry/vec.hpp"

namespace cairn::fragility {

inline constexpr double kGravity = 9.80665;  // m/s^2

// Whether the contact can hold the rock up at all.
enum class Equilibrium {
  stable,                // the plumb point lies inside the support polygon
  no_contact,            // no contact point given
  point_contact,         // one distinct point in plan: the rock may roll, alpha does not describe it
  line_contact,          // all points on one line in plan
  plumb_point_outside,   // the plumb point lies outside, or on the border within the tolerance
  contact_above_centre,  // a contact is not below the centre of mass: held from the side
};
[[nodiscard]] const char* reason_of(Equilibrium state);  // "" when stable, else the reason code

// One edge about which the rock can tip. SI, angles in rad.
struct Edge {
  std::array<geometry::Vec3, 2> ends{geometry::Vec3::Zero(), geometry::Vec3::Zero()};  // m, the mesh's frame
  std::array<std::size_t, 2> contacts{};  // indices into the contact points given
  double azimuth_deg = 0.0;               // horizontal outward normal, clockwise from +y (north), 0 <= a < 360
  double inclination = 0.0;               // delta: of the edge to the horizontal, 0..pi/2
  double alpha = 0.0;                     // rotation about the edge that brings the centre of mass above it
  double r = 0.0;                         // R: distance of the centre of mass from the edge's line, m
  double inertia_per_mass = 0.0;          // about the edge, m^2
  double p = 0.0;                         // sqrt(g R cos(delta) m / I), rad/s
  // Least acceleration along the normal / g: cos(delta) tan(alpha). Infinite, like v_min, where the
  // line of a steep edge passes above the centre of mass (alpha >= pi/2): such an edge is never critical.
  double a_qs_g = 0.0;
  double v_min = 0.0;             // least velocity step along the normal, m/s
  double barrier_per_mass = 0.0;  // g R cos(delta) (1 - cos(alpha)), J/kg
};

struct TippingResult {
  Equilibrium equilibrium = Equilibrium::no_contact;
  // Support polygon: outline of the contacts along z, counter-clockwise from above, 3-D vertices.
  // Empty without contacts; fewer than three vertices for a point or a line.
  std::vector<geometry::Vec3> support;
  double plumb_margin = 0.0;  // m from the plumb point to the polygon's border, < 0 outside
  // All below is filled only when stable.
  std::vector<Edge> edges;                // in order of azimuth of the support outline seen from the centre of mass
  std::optional<std::size_t> critical;    // edge of least alpha (ties: the lower index)
  std::vector<double> a_qs_g_by_azimuth;  // 360 values: toppling towards 0, 1, .. 359 deg from +y clockwise
  double a_qs_min_g = 0.0;                // least over all azimuths, not only whole degrees
  double a_qs_min_azimuth_deg = 0.0;
  double alpha_point = 0.0;  // definition (a): least angle(down, q - centre of mass) over the contacts given
};

// fragility.md section 7, with its test for contacts that are not coplanar in closed form:
// seen from the centre of mass c, a contact q below it maps to w = (q - c)_xy / (c_z - q_z).
// A force (a u, -g) through c meets the hull of the contacts iff (a/g) u lies in the plane hull W of
// the w_i (a central projection keeps convexity), so a_qs(u)/g is the radial distance of W's border
// towards u, and the edges of W are exactly the edges about which the rock can tip.
//
// mass: closed outward mesh, z true vertical, any density. contacts: same frame, m, any order,
// any number; z may differ. tolerance [m]: plumb points closer than this to the border count
// as outside (alpha = 0 is never reported). Limits: rigid, unilateral parallel contact forces,
// no friction, no wedging; conservative. Cost n log n + 360 edges; without azimuths (the table and the least over all
// directions stay empty) n log n.
enum class Azimuths { all, none };
[[nodiscard]] TippingResult tipping(const geometry::MassProperties& mass, std::span<const geometry::Vec3> contacts,
                                    double tolerance = 1e-6, Azimuths azimuths = Azimuths::all);

// The edge about which the rock rocks back after the edge `from`: the one that a push the opposite way topples about.
// Precondition: result is stable.
[[nodiscard]] std::size_t opposite_edge(const TippingResult& result, std::size_t from);

}  // namespace cairn::fragility
