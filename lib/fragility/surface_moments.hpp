// How volume, centre of mass and inertia answer to small displacements of a surface, patch by patch.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fragility/contact_line.hpp"
#include "geometry/mass_properties.hpp"
#include "geometry/triangle_mesh.hpp"

namespace cairn::fragility {

// Integrals over a piece of surface, of 1, x and x x^T, x from the centre of mass: to first order a displacement of 1 m
// outwards adds just these to the volume and its first and second moments.
struct SurfaceMoments {
  double area = 0.0;                               // m^2
  geometry::Vec3 first = geometry::Vec3::Zero();   // m^3
  geometry::Mat3 second = geometry::Mat3::Zero();  // m^4
  double unseen = 0.0;                             // m^2 of `area` that no point supports

  void add(double weight, const geometry::Vec3& x);
};

// The surface cut along a cubic lattice of cells of the given edge [m]; in a fixed order. seen: a flag a triangle, or
// none = not known. Cost n log n.
[[nodiscard]] std::vector<SurfaceMoments> surface_patches(const geometry::TriangleMesh& mesh,
                                                          const geometry::Vec3& centre, double cell,
                                                          std::span<const std::uint8_t> seen);

// The cap inside the contact's pads, as fans about their middles: displaced downwards (added to the rock) by 1 m all
// over
// (`level`), or by a bump that is 1 m in the middle and 0 at the line (`bump`, 1 - rho^2).
struct CapMoments {
  SurfaceMoments level, bump;
  double bump_squared = 0.0;  // m^2, integral of the bump's square: height of the added volume's own middle
};
[[nodiscard]] CapMoments cap_moments(const std::vector<ContactVertex>& contact, const geometry::Vec3& centre);

// Volume, first and second moments about a fixed point, unit density; from and to mass properties.
struct BodyMoments {
  double volume = 0.0;
  geometry::Vec3 first = geometry::Vec3::Zero();
  geometry::Mat3 second = geometry::Mat3::Zero();

  void add(double displacement, const SurfaceMoments& patch);
};
// About the mass's own centre.
[[nodiscard]] BodyMoments moments_of(const geometry::MassProperties& mass);
// `about`: the point the moments are taken about. Precondition: volume > 0.
[[nodiscard]] geometry::MassProperties mass_of(const BodyMoments& moments, const geometry::Vec3& about, double area);

}  // namespace cairn::fragility
