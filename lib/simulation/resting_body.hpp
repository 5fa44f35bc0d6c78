// What every generator of bodies returns, before it is tilted, turned and set on a pedestal.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/random.hpp"
#include "geometry/triangle_mesh.hpp"
#include "geometry/vec.hpp"
#include "simulation/shape.hpp"

namespace cairn::simulation {

using Ring3 = std::vector<geometry::Vec3>;

// Own axes: x length, y width, z up; the extents of the body are those of the spec. The seat is the surface under
// the body; its middle lies near the origin.
struct RestingBody {
  geometry::TriangleMesh body;
  std::vector<Ring3> rim, bearing;
  std::size_t sectors = 0;  // directions about the middle of the seat, counter-clockwise
  // Point of the seat in a sector, at `factor` times the distance of the rim: 0 = the middle, 1 = below the rim,
  // more = outside it.
  std::function<geometry::Vec3(std::size_t sector, double factor)> seat;
  std::string family;
};

[[nodiscard]] RestingBody make_rock(const ShapeSpec& spec, double edge, base::Random& random);
[[nodiscard]] RestingBody make_solid(const ShapeSpec& spec, double edge);
[[nodiscard]] RestingBody make_tree(const ShapeSpec& spec, double edge, base::Random& random);

// Closed mesh of rings of equal length, from the top down, each counter-clockwise seen from above.
[[nodiscard]] geometry::TriangleMesh ring_mesh(const geometry::Vec3& top, const std::vector<Ring3>& rings,
                                               const geometry::Vec3& bottom);
// Stretches each axis about the origin so that the extents are exactly `size`; components of 0 stay as they are.
[[nodiscard]] geometry::Vec3 stretch_to(const geometry::TriangleMesh& mesh, const geometry::Vec3& size);
// Appends a mesh as further components.
void append(geometry::TriangleMesh& mesh, const geometry::TriangleMesh& more);

}  // namespace cairn::simulation
