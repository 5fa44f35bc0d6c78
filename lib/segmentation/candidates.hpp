// Objects that stand out of the ground, without being told where.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/options.hpp"
#include "geometry/vec.hpp"
#include "segmentation/ground_filter.hpp"

namespace cairn::segmentation {

struct CandidateOptions {
  double min_height_m = 0.2;  // the highest point of an object stands at least this above the ground
  double min_width_m = 0.2;   // square root of its area in plan
  double max_width_m = 0.0;   // diameter of its circle in plan; 0: any
  double join_gap_m = 0.0;    // gaps in plan up to this width do not part an object; 0: one cell
  std::int64_t min_points = 20;

  void visit(base::OptionVisitor& visitor);
};

// One connected object seen from above. Touching rocks are one candidate: whoever segments splits them.
struct Candidate {
  std::vector<std::uint32_t> points;               // above the ground, indices into the cloud, ascending
  std::vector<geometry::Vec2> footprint;           // convex hull of the points in plan, counter-clockwise, m
  geometry::Vec2 centre = geometry::Vec2::Zero();  // of the smallest circle around the footprint, m
  geometry::Vec2 anchor = geometry::Vec2::Zero();  // centre of its northernmost, then westernmost cell, m
  double radius = 0.0;                             // of that circle, m
  double area = 0.0;                               // of its cells, m2
  double height = 0.0;                             // of its highest point above the ground, m
  double ground_up = 0.0;                          // local up of the interpolated ground at the centre, m
  bool touches_border = false;                     // of the grid: the object may go on beyond
};

// Connected groups (8 neighbours, after closing by join_gap_m) of cells of the ground grid with points `above` that
// stand at least half of min_height_m above the ground; points `above` in the cells beside a group belong to it.
// Order: by the northernmost, then westernmost cell, so that results do not depend on the order of the points.
// Limits: plan view only; objects under a tree crown are one with it. Cost linear.
[[nodiscard]] std::vector<Candidate> find_candidates(std::span<const geometry::Vec3> points,
                                                     const GroundFilterResult& ground, const CandidateOptions& options);

}  // namespace cairn::segmentation
