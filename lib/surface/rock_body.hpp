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
#include "survey/contact.hpp"
#include "survey/rock.hpp"

namespace cairn::surface {

struct BodyOptions {
  // "implicit": smooth surface through points seen from all sides, cap on the contact line; "top": height field, skirt,
  // cap (points from above); "wrap": alpha wrapping; "auto": implicit where there are at least dense-min-points and
  // the flanks were seen, else top.
  std::string method = "auto";
  // "patch": through the contact line; "plane": its best-fit plane; "auto": patch where a contact was given.
  std::string cap = "auto";
  std::int64_t dense_min_points = 500;
  double dense_min_flanks = 0.5;  // share of azimuths whose flank was seen from the ground up, or of contact observed
  double implicit_max_unseen = 0.75;  // auto: a surface of which more than this is made up, caps included, is not taken
  double wrap_alpha_factor = 4.0;     // alpha = this many spacings; grown while the wrap leaks into the rock
  double wrap_offset_factor = 1.0;    // offset = this many spacings; taken off again afterwards
  double rim_edge_factor = 5.0;       // top: outline edges longer than this many plan spacings are followed inwards
  double clearance_m = 0.002;         // top: least height of the surface above its cap

  void visit(base::OptionVisitor& visitor);
};

struct BodyInput {
  std::span<const geometry::Vec3> points;               // of the rock, m, z up
  std::function<double(const geometry::Vec2&)> ground;  // up of the ground at a plan position, m
  double spacing = 0.0;                                 // median distance to the nearest neighbour, m, > 0
  double flanks_seen_share = 0.0;                       // of the azimuths, 0..1: flank seen from the ground up
  survey::Contact contact;                              // line on which the rock rests, the points' frame; may be empty
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
  std::string method;              // "implicit", "top", "wrap", or "given"
  survey::CapModel cap = survey::CapModel::plane;
  BodyQuality quality;
  geometry::MassProperties mass;  // unit density
  double hull_volume = 0.0;       // m^3, convex hull of the mesh: upper bound
  double point_spacing = 0.0;     // m: square root of the area a point stands for; implicit only, else 0
  double noise = 0.0;             // m: standard deviation of the points about the mesh; implicit only, else 0
  double cap_height_sigma = 0.0;  // m: of the cap about the true base; 0 = not known
  survey::Contact contact;        // the line the cap was laid through; assumed where the input had none
  bool contact_assumed = true;
  // Codes: implicit_unsupported, stray_points, pieces_dropped, offset_kept, wrap_leaked, turned_outwards,
  // self_intersecting; of given meshes those of mesh_repair.hpp.
  std::vector<std::string> notes;
};

// Rejects (record left to the caller): too_few_points, flat_points (no area in plan or no volume), surface_not_closed,
// self_intersecting, several_pieces, wrap_leaks (the points leave gaps of more than a third of the rock),
// implicit_unsupported (no closed surface from the points; under `auto` the top surface is taken, with a note):
// volumes of such meshes are never reported.
[[nodiscard]] std::variant<RockBody, base::Reject> build_body(const BodyInput& input, const BodyOptions& options);

// Quality, mass and hull of a mesh that is there already, after `repair` (mesh_repair.hpp): welded, agreeing, outwards,
// an open base and holes closed. What was made counts as unseen; with a closed base the cap is `patch` and `contact`
// its outline, assumed. One that passes through itself is kept, with the note self_intersecting and watertight = false:
// its mass properties are those of the signed sums. Rejects beside the above: surface_not_closed where more than half
// of the surface would have to be made.
[[nodiscard]] std::variant<RockBody, base::Reject> body_of(const geometry::TriangleMesh& mesh);

}  // namespace cairn::surface
