// coverage.json: the audit in figures.
#pragma once

#include <span>
#include <vector>

#include "coverage/audit.hpp"
#include "coverage/coverage.hpp"
#include "geometry/triangle_mesh.hpp"
#include "io/json.hpp"

namespace cairn::pipeline {

struct CoverageFigures {
  io::Json summary;     // completeness, areas, gates, percentiles
  io::Json histograms;  // area by metric: {metric, title, unit, edges, areas_m2, gate, gate_is_minimum}
};

// `sides` of the summary: facets whose normal rises by less than 0.2, walls and undersides, apart.
// Areas are of observed facets [m^2]. Cost linear, n log n for the percentiles.
[[nodiscard]] CoverageFigures coverage_figures(const geometry::TriangleMesh& mesh,
                                               const coverage::FacetCoverage& metrics, const coverage::Audit& audit,
                                               const coverage::GateOptions& gates);

}  // namespace cairn::pipeline
