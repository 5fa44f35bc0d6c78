// How far a drawn line lies from the true one.
#pragma once

#include <cstddef>
#include <vector>

#include "geometry/vec.hpp"

namespace cairn::evaluation {

struct Polyline {
  std::vector<geometry::Vec3> points;  // m
  bool closed = true;                  // the last point joins the first
};

// m. Distances are taken at points every `step` along one line to the nearest point of the other lines, so that they
// are means over length and do not depend on how densely a line is drawn.
struct LineDistance {
  double mean = 0.0;        // of the found lines to the true ones
  double p95 = 0.0;         // the same, 95 % quantile
  double from_true = 0.0;   // mean of the true lines to the found ones: what was left out shows here
  double hausdorff = 0.0;   // largest of both ways
  std::size_t samples = 0;  // of both; 0 = one of them is empty, and nothing else is set
};

// Lines of one point count as that point. Cost (samples of one) x (segments of the other).
// Throws invalid_argument where step is not > 0.
[[nodiscard]] LineDistance line_distance(const std::vector<Polyline>& found, const std::vector<Polyline>& truth,
                                         double step = 0.005);

}  // namespace cairn::evaluation
