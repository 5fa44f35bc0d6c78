// Connected patches of facets that fail, with outline and the frames to start from.
#pragma once

#include <vector>

#include "base/options.hpp"
#include "coverage/audit.hpp"
#include "coverage/view.hpp"
#include "geometry/triangle_mesh.hpp"
#include "survey/coverage_gap.hpp"

namespace cairn::coverage {

struct GapOptions {
  double min_area_m2 = 1.0;         // smaller patches are left out of the list (not of the completeness)
  std::int64_t nearest_frames = 3;  // named with each gap

  void visit(base::OptionVisitor& v) {
    v.real("min-gap-area-m2", min_area_m2, 0.0, 1e9, "surface area below which a gap is not listed, m^2");
    v.integer("nearest-frames", nearest_frames, 0, 100, "frames named with each gap");
  }
};

// Facets that share an edge (the same two vertex indices: weld a mesh of loose triangles first) and fail for the same
// reason form one gap. Largest area first; ids count from 0.
//   rings: outline seen from above, straight runs reduced to their ends; where the patch is steeper than 80 deg or
//          folds over, the convex hull of its vertices seen from above.
//   centre: centroid of the facet closest to the patch's centroid, so that it lies on the surface.
//   view: along the patch's mean normal, at the median distance of the views from it; empty where there are no views
//         or the normal points below the horizon.
// Cost n log n in failing facets.
[[nodiscard]] std::vector<survey::CoverageGap> find_gaps(const geometry::TriangleMesh& mesh,
                                                         const std::vector<Verdict>& verdicts, const ViewSet& views,
                                                         const GapOptions& options);

}  // namespace cairn::coverage
