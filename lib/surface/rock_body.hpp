// One rock's points to a closed body: mesh, quality, mass properties.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "base/options.hpp"
#include "base/reject.hpp"
#include "geometry/mass_properties.hpp"
#include "geometry/triangle_mesh.hpp"
#include "survey/rock.hpp"

namespace cairn::surface {

struct BodyOptions {
  // "top": height field, skirt, cap (points from above); wrap: alpha wrapping (points all round);
  // auto: wrap where there are at least wrap-min-points and the flanks were seen, else top.
  std::string method = "auto";
  std::int64_t wrap_min_points = 500;
  double wrap_min_flanks = 0.75;    // share of azimuths whose flank was seen from the ground up
  double wrap_alpha_factor = 4.0;   // alpha = this many spacings; grown while the wrap leaks into the rock
  double wrap_offset_factor = 1.0;  // offset = this many spacings; taken off again afterwards
  double rim_edge_factor = 5.0;     // top: outline edges longer than this many plan spacings are followed inwards
  double clearance_m = 0.002;       // top: least height of the surface above its cap

  void visit(base::OptionVisitor& visitor);
};

struct BodyInput {
  std::span<const geometry::Vec3> points;               // of the rock, m, z up
  std::function<double(const geometry::Vec2&)> ground;  // up of the ground at a plan position, m
  double spacing = 0.0;                                 // median distance to the nearest neighbour, m, > 0
  double flanks_seen_share = 0.0;                       // of the azimuths, 0..1: flank seen from the ground up
};

struct BodyQuality {
  geometry::MeshTopology topology;
  bool self_intersecting = false;
  double unseen_area_fraction = 1.0;  // skirt, cap and bridges / whole surface
  // Closed, oriented, one piece, not self-intersecting, positive volume.
  bool watertight = false;
};

struct RockBody {
  geometry::TriangleMesh mesh;
  std::vector<std::uint8_t> seen;  // a flag a triangle: 1 = supported by points
  std::string method;              // "top" or "wrap"
  survey::CapModel cap = survey::CapModel::plane;
  BodyQuality quality;
  geometry::MassProperties mass;   // unit density
  double hull_volume = 0.0;        // m^3, convex hull of the mesh: upper bound
  std::vector<std::string> notes;  // codes: offset_kept, wrap_leaked, turned_outwards, self_intersecting
};

// Rejects (record left to the caller): too_few_points, flat_points (no area in plan or no volume), surface_not_closed,
// self_intersecting, several_pieces, wrap_leaks (the points leave gaps of more than a third of the rock; under
// `auto` the top surface is taken instead, with the note wrap_leaked): volumes of such meshes are never reported.
[[nodiscard]] std::variant<RockBody, base::Reject> build_body(const BodyInput& input, const BodyOptions& options);

// Quality, mass and hull of a mesh that is there already (welded, turned outwards where its volume is
// negative). Everything counts as seen. One that passes through itself is kept, with the note
// self_intersecting and watertight = false: its mass properties are those of the signed sums.
[[nodiscard]] std::variant<RockBody, base::Reject> body_of(const geometry::TriangleMesh& mesh);

}  // namespace cairn::surface
