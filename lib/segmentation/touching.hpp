// Rocks that touch: one object seen from above, several tops.
#pragma once

#include <span>
#include <vector>

#include "geometry/vec.hpp"
#include "segmentation/candidates.hpp"
#include "segmentation/ground_filter.hpp"

namespace cairn::segmentation {

struct TouchingOptions {
  double saddle_share = 0.04;  // of the lower top's height: how far the saddle between two tops lies below it, at least
  double saddle_m = 0.05;      // and in metres; 0 and 0 part every top
  double cell_spacings = 4.0;  // cell of the heights over the spacing of the points

  void visit(base::OptionVisitor& visitor);
};

// The candidate itself where it has one top, else one a top: heights of the highest points in plan are flooded from
// above (Meyer's watershed by union), and two basins stay apart where the lower top stands out of the saddle far
// enough (topological persistence). Of each part the points, footprint, circle, area and height are its own.
// Limits: a low rock that leans against a high one without a saddle between stays part of it; a rock with two horns
// is parted. Cost n log n.
[[nodiscard]] std::vector<Candidate> part_touching(const Candidate& candidate, std::span<const geometry::Vec3> points,
                                                   const GroundFilterResult& ground, const TouchingOptions& options);

}  // namespace cairn::segmentation
