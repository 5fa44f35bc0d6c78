// A digitised basal contact: its pads, what share of it was seen, its plane, and points along it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/primitives.hpp"
#include "survey/contact.hpp"

namespace cairn::fragility {

using survey::ContactVertex;

// Sorted by pad and order (stable).
void sort_contact(std::vector<ContactVertex>& contact);

// Share of the lines' length whose both ends were observed, 0..1; sorted contact. A single point counts by itself.
[[nodiscard]] double observed_share(const std::vector<ContactVertex>& contact);

// Vertices farther than `margin` [m] outside the box of the mesh: a contact of another rock or frame.
[[nodiscard]] std::size_t outside_count(const std::vector<ContactVertex>& contact, const geometry::Box3& box,
                                        double margin);

// One patch of a sorted contact: vertices [first, last).
struct Pad {
  std::int64_t id = 0;
  std::size_t first = 0, last = 0;
};
[[nodiscard]] std::vector<Pad> pads_of(const std::vector<ContactVertex>& contact);

// Mean of the pad's outline weighted by length, m; of its points where they coincide.
[[nodiscard]] geometry::Vec3 middle_of(const std::vector<ContactVertex>& contact, const Pad& pad);

// The same lines with vertices at most `step` [m] apart: status observed only between two observed ends, sigma
// interpolated. At most `limit` vertices a pad: a finer step is widened. Original vertices are kept where the limit
// allows. Cost linear.
[[nodiscard]] std::vector<ContactVertex> densified(const std::vector<ContactVertex>& contact, double step,
                                                   std::size_t limit);

// Distance along the line from the pad's first vertex, m, a value a vertex; its total length is returned through
// `length` (with the closing side).
[[nodiscard]] std::vector<double> arc_lengths(const std::vector<ContactVertex>& contact, const Pad& pad,
                                              double& length);

// Least-squares plane through the points.
struct ContactPlane {
  geometry::Vec3 centre = geometry::Vec3::Zero();
  geometry::Vec2 gradient = geometry::Vec2::Zero();  // rise of the plane, m/m east, m/m north
  double slope = 0.0;                                // rad, to the horizontal
  double aspect_deg = 0.0;                           // it falls this way, clockwise from north; 0 where level
};
[[nodiscard]] ContactPlane contact_plane(const std::vector<ContactVertex>& contact);

[[nodiscard]] std::vector<geometry::Vec3> positions_of(const std::vector<ContactVertex>& contact);

}  // namespace cairn::fragility
