// What a coverage audit shows: layers, a coloured mesh, the audit page.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/run_context.hpp"
#include "coverage/audit.hpp"
#include "coverage/coverage.hpp"
#include "coverage/target_audit.hpp"
#include "io/json.hpp"
#include "pipeline/coverage_frames.hpp"
#include "pipeline/coverage_raster.hpp"
#include "pipeline/coverage_views.hpp"
#include "survey/coverage_gap.hpp"

namespace cairn::pipeline {

// coverage.gpkg: layers `frames`, `footprints` (at the median height of the surface), `gaps`.
void write_coverage_layers(const std::filesystem::path& path, const CoverageViews& views,
                           const geometry::TriangleMesh& surface, const std::vector<survey::CoverageGap>& gaps);

// Metrics that a mesh may be coloured by.
[[nodiscard]] const std::vector<std::string>& colour_metrics();

// coverage.ply and coverage.glb: each facet in the colour of its value; the key is in the files' comments and extras.
// Degenerate facets are left out. metric: of colour_metrics() but "none". Without facets nothing is written.
void write_coloured_mesh(const std::filesystem::path& folder, const geometry::TriangleMesh& mesh,
                         const coverage::FacetCoverage& metrics, const coverage::Audit& audit,
                         const std::string& metric);

// audit.html. summary, histograms: as in coverage.json. cells: empty for a camera table.
void write_coverage_page(const std::filesystem::path& path, const std::string& title, const io::Json& summary,
                         const io::Json& histograms, const std::vector<survey::CoverageGap>& gaps,
                         const std::vector<FrameFigures>& frames, const std::vector<coverage::TargetAudit>& targets,
                         const std::optional<CoverageCells>& cells, double max_blur_px,
                         const std::vector<std::string>& notes);

}  // namespace cairn::pipeline
