// Bodies with truth: closed meshes of rocks, analytic solids and trees, and the contact they rest on.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/random.hpp"
#include "geometry/triangle_mesh.hpp"
#include "geometry/vec.hpp"

namespace cairn::simulation {

enum class ShapeKind { sphere, ellipsoid, box, cylinder, cone, rock, tree, mesh };

[[nodiscard]] std::string_view name_of(ShapeKind kind);
[[nodiscard]] std::optional<ShapeKind> shape_kind_from(std::string_view name);

// Families of generated rocks: rounded, angular, slab, pear, stacked; of trees: broadleaf, conifer, bush.
[[nodiscard]] const std::vector<std::string>& rock_families();
[[nodiscard]] const std::vector<std::string>& tree_families();

struct ShapeSpec {
  ShapeKind kind = ShapeKind::rock;
  // Length, width and height of the body in its own axes, before it is tilted and turned; m, > 0.
  // A sphere, a cylinder and a cone may be elliptical in plan. Kind `mesh`: components of 0 follow the others in
  // proportion; all 0 = as it is.
  geometry::Vec3 size_m = geometry::Vec3(1.0, 1.0, 1.0);
  double azimuth_deg = 0.0;  // of the length axis, clockwise from north
  double tilt_deg = 0.0;     // of body and seat towards the azimuth, 0..45
  // Rocks and trees: departure from the family's smooth form, 0..1.
  double irregularity = 0.5;
  std::string family;  // one of the above; "" = drawn

  // A pedestal whose seat stands this high above the ground (its lowest contact point); 0 = none. Its top
  // reaches pedestal_radius_m from the middle of the contact, and at least a little beyond the rim; 0 = 1.3 x the
  // rim's mean radius. It goes kPedestalDepth below the ground, so that uneven terrain does not uncover its foot.
  double pedestal_height_m = 0.0;
  double pedestal_radius_m = 0.0;

  // Rocks: mean radius of the contact rim over the mean radius of the widest section; 0 = drawn from 0.35..0.7.
  double foot_share = 0.0;
  // Area that bears over the area inside the visible rim, in plan; 0 < share <= 1, 1 = the rim bears.
  double contact_share = 1.0;
  // Rocks: separate bearing areas, 1..5. More than one: `contact_share` is met as far as the pads find room.
  int contact_pads = 1;
  double contact_gap_m = 0.004;  // rocks: opening of the crease at the rim where the rim does not bear, >= 0

  double edge_m = 0.0;          // wanted length of triangle edges, m; 0 = a fiftieth of the largest size
  geometry::TriangleMesh mesh;  // kind `mesh`: closed, any frame with z up
};

inline constexpr double kPedestalDepth = 0.5;  // m

// Origin = foot on the ground (below the middle of the contact), up = +z, x east, y north.
struct Shape {
  geometry::TriangleMesh body, pedestal;  // each closed and outward; the pedestal may be empty
  // Closed rings (no repeated last point), counter-clockwise from above. The rim is the visible crease, on the
  // body's lower edge; the bearing rings lie inside it (or on it), where the body touches the seat. Both are empty
  // for a contact of one point (sphere, ellipsoid), for trees and for given meshes.
  std::vector<std::vector<geometry::Vec3>> contact_rim, contact_bearing;
  double volume_m3 = 0.0;                                  // of the body's mesh
  geometry::Vec3 centre_of_mass = geometry::Vec3::Zero();  // of a uniform body
  std::string family;                                      // the one used; "" for kinds that have none
};

// The same spec and state of `random` give the same bytes. A rock stands in equilibrium: its centre of mass lies
// above the bearing contact, whatever the tilt. A tree is several closed components that may overlap; its
// volume counts overlaps twice. Cost linear in triangles; a rock of 20 000 triangles about 50 ms.
// Throws invalid_argument where the spec is out of range.
[[nodiscard]] Shape make_shape(const ShapeSpec& spec, base::Random& random);

}  // namespace cairn::simulation
