// The line along which a rock meets what it stands on, from points that are labelled.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/vec.hpp"
#include "segmentation/labels.hpp"
#include "survey/contact.hpp"

namespace cairn::segmentation {

// The surfaces that meet in the line at one of its vertices, in the upright plane across it.
struct ContactProfile {
  geometry::Vec3 position = geometry::Vec3::Zero();  // where they meet, m
  geometry::Vec2 outward = geometry::Vec2::UnitX();  // in plan, unit: away from the rock's foot
  geometry::Vec2 flank = geometry::Vec2(0.0, 1.0);   // from the line along the rock's flank: outward, up; unit
  geometry::Vec2 seat = geometry::Vec2(1.0, 0.0);    // the same along the seat
  double sigma = 0.0;                                // of position across the line, m
  bool observed = false;                             // points of both surfaces stand at the line itself
  std::size_t pad = 0;
};

struct ContactLine {
  std::vector<ContactProfile> profiles;         // pad by pad, counter-clockwise from above
  double residual = 0.0;                        // robust deviation of the points from the two surfaces, m
  [[nodiscard]] double observed_share() const;  // of the profiles
  [[nodiscard]] survey::Contact contact() const;
};

// Which side of the contact a point is known to lie on.
enum class Side : std::uint8_t { other = 0, rock = 1, unknown = 2 };

// points: m, finite, of one rock and its surroundings; sides: one a point; spacing: of the points, m, > 0.
// The line is followed by direction about the middle of each pad (pads whose crease closes about a middle of their
// own are told apart). Per direction the flank above and the seat outside are each taken as a straight line over some
// 12 spacings; the crease is where they meet, which holds where the crease itself is hidden. Then smoothed along the
// rim over some 5 spacings. Empty where rock and other points do not come near one another. n log n.
[[nodiscard]] ContactLine fit_contact(std::span<const geometry::Vec3> points, std::span<const Side> sides,
                                      double spacing);

// The contact of one rock in a labelled cloud: labels rock against pedestal, terrain and none; points of label basal
// contact lie on the line. Frame and unit of the points.
[[nodiscard]] survey::Contact contact_from_labels(std::span<const geometry::Vec3> points,
                                                  std::span<const Label> labels);

}  // namespace cairn::segmentation
