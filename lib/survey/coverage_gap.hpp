// A part of the surface that the flight did not see well enough: what a coverage audit finds.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "geometry/primitives.hpp"
#include "geometry/vec.hpp"
#include "survey/ids.hpp"

namespace cairn::survey {

using GapId = base::Id<struct GapTag>;

// Where a camera would have to stand, and what it would look at, to close the gap.
struct SuggestedView {
  geometry::Vec3 position = geometry::Vec3::Zero();  // camera centre, local ENU, m
  geometry::Vec3 look_at = geometry::Vec3::Zero();   // local ENU, m
};

struct CoverageGap {
  GapId id;
  // Outline seen from above, local ENU, m. The first ring is the outer one (counter-clockwise), the
  // others are its holes (clockwise). No repeated last vertex. Not empty.
  std::vector<geometry::Ring> rings;
  geometry::Vec3 centre = geometry::Vec3::Zero();  // a point of the surface inside the gap, local ENU, m
  double area_m2 = 0.0;                            // of the surface (not of its plan), > 0
  std::size_t facets = 0;                          // of the audited surface
  std::string reason;                   // reason code, snake_case: "no_view", "too_few_views", "low_parallax", ...
  std::vector<FrameId> nearest_frames;  // nearest first; those that came closest to seeing it
  std::optional<SuggestedView> view;    // empty where none was found
};

}  // namespace cairn::survey
