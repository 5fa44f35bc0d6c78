// A rock as a rigid body: its own mass properties, the points it rests on, convex pieces for its flanks.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/options.hpp"
#include "geometry/mass_properties.hpp"
#include "geometry/triangle_mesh.hpp"
#include "geometry/vec.hpp"

namespace cairn::dynamics {

// SI, all in the mesh's frame, z true vertical.
struct RigidRock {
  double mass_kg = 0.0;
  geometry::Vec3 centre_of_mass_m = geometry::Vec3::Zero();
  geometry::Mat3 inertia_kg_m2 = geometry::Mat3::Zero();  // about the centre of mass
  // The corners about which it can tip, counter-clockwise from above. Each rests on a pad of its own: a plane through
  // it with the normal below.
  std::vector<geometry::Vec3> foot_m;
  geometry::Vec3 pad_normal = geometry::Vec3::UnitZ();  // of the plane fitted to the foot, upward unit vector
  double foot_off_plane_m = 0.0;                        // largest distance of a corner from that plane
  std::vector<std::vector<geometry::Vec3>> pieces_m;    // corners of convex pieces, from the base upwards
};

struct RigidRockOptions {
  std::int64_t slabs = 8;        // the flanks: convex hulls of this many level slices of the mesh
  double clearance_m = 0.01;     // slices begin this far above the pads, so that the declared contact alone bears
  std::int64_t directions = 96;  // corners kept a slice: its farthest points in this many directions

  void visit(base::OptionVisitor& visitor);
};

// mass: of the closed mesh, unit density. contacts: the contact's points [m], any order; a corner of the foot is a
// contact that an edge of the hull of fragility.md section 7 ends at (central projection from the centre of mass), so a
// contact of several pads or of uneven height keeps all the points that bear and no other. Throws failed_precondition
// where they cannot hold the rock up: fewer than three corners, a contact at or above the centre of mass, the plumb
// point outside. Cost: n log n in contacts, linear in triangles x slabs.
[[nodiscard]] RigidRock rigid_rock(const geometry::TriangleMesh& mesh, const geometry::MassProperties& mass,
                                   double density_kg_m3, std::span<const geometry::Vec3> contacts,
                                   const RigidRockOptions& options = {});

}  // namespace cairn::dynamics
