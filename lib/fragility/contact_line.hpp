// A digitised basal contact, and what share of it was seen.
#pragma once

#include <cstddef>
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

}  // namespace cairn::fragility
