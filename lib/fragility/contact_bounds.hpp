// What the unseen part of a contact can do to the tipping angle: bounds, pads taken away, gaps counted as closed.
#pragma once

#include <span>
#include <vector>

#include "fragility/contact_line.hpp"
#include "geometry/mass_properties.hpp"
#include "geometry/triangle_mesh.hpp"
#include "survey/rock.hpp"

namespace cairn::fragility {

struct ContactBounds {
  survey::TippingBound inner, outer;
};

// outer: all vertices, so the visible crease with its gaps closed as the line says: what bears cannot reach farther.
// inner: the seen vertices only (a missing sector adds nothing), each pad drawn in towards its middle by the share
// `inset` of the distance: the rim hides where the rock really bears. Reason `no_contact_seen` where fewer than three
// vertices were observed: no lower bound is known then. contact sorted; inset 0..0.95; tolerance as in tipping().
[[nodiscard]] ContactBounds contact_bounds(const geometry::MassProperties& mass,
                                           const std::vector<ContactVertex>& contact, double inset, double tolerance);

// Each pad drawn in towards its middle by the share `inset` of the distance.
[[nodiscard]] std::vector<geometry::Vec3> inset_contact(const std::vector<ContactVertex>& contact, double inset);

// Least alpha with each pad taken away in turn; empty for a single pad.
[[nodiscard]] std::vector<survey::TippingVariant> without_each_pad(const geometry::MassProperties& mass,
                                                                   const std::vector<ContactVertex>& contact,
                                                                   double tolerance);

// Least alpha when the rock also bears wherever its underside is closer than each gap [m] to the seat. The seat is
// taken at the height of the nearest point of the line (in plan), and to go on like that outside it. A curved base
// rolls outwards in this way before it tips, so alpha grows with the gap; on a block it stays. Cost: vertices near the
// base x contact vertices.
[[nodiscard]] std::vector<survey::TippingVariant> by_gap(const geometry::MassProperties& mass,
                                                         const geometry::TriangleMesh& mesh,
                                                         const std::vector<ContactVertex>& contact,
                                                         std::span<const double> gaps, double tolerance);

}  // namespace cairn::fragility
