// A digitised basal contact, and what share of it was seen.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/primitives.hpp"
#include "geometry/vec.hpp"

namespace cairn::fragility {

struct ContactVertex {
  std::int64_t pad = 0;                              // separate contact patches of one rock
  std::int64_t order = 0;                            // along the patch's outline
  geometry::Vec3 position = geometry::Vec3::Zero();  // m, the mesh's frame
  bool observed = false;
  bool closed = true;  // the patch's last vertex joins its first
};

// Sorted by pad and order (stable).
void sort_contact(std::vector<ContactVertex>& contact);

// Share of the lines' length whose both ends were observed, 0..1; sorted contact. A single point counts by itself.
[[nodiscard]] double observed_share(const std::vector<ContactVertex>& contact);

// Vertices farther than `margin` [m] outside the box of the mesh: a contact of another rock or frame.
[[nodiscard]] std::size_t outside_count(const std::vector<ContactVertex>& contact, const geometry::Box3& box,
                                        double margin);

}  // namespace cairn::fragility
