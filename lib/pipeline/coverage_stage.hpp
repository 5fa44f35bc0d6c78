// Stage `coverage`: surface + views -> what was seen, what was missed and why.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "base/run_context.hpp"
#include "coverage/audit.hpp"
#include "coverage/coverage.hpp"
#include "coverage/gaps.hpp"
#include "pipeline/outcome.hpp"
#include "pipeline/stage.hpp"

namespace cairn::pipeline {

struct CoverageInputs {
  std::filesystem::path surface;  // GeoTIFF with a band `surface`, or a mesh
  std::filesystem::path views;    // survey folder, or a camera table
  std::string format = "auto";    // auto: a folder is a survey, a file is a camera table; survey; pinhole-table
};

struct CoverageStageOptions {
  coverage::CoverageOptions visibility;  // its flag `metrics` must be on
  coverage::GateOptions gates;
  coverage::GapOptions gaps;
  bool facets_csv = false;      // facets.csv: a row a facet
  double raster_cell_m = 0.25;  // cell of views.tif where the surface is a mesh

  void visit(base::OptionVisitor& v);
};

// Writes into `out`:
//   coverage.json  completeness, area by verdict, gates, histograms, percentiles, with definitions
//   views.tif      float bands `views`, `gsd_mm`, `incidence_deg`, `parallax_deg`: the worst of a cell's facets; NaN
//                  where nothing was observed. For a mesh: of the facet seen from straight above. Not without a frame.
//   gaps.json      connected patches that fail (survey::CoverageGap). Not without a frame.
//   facets.csv     on request
// The summary is coverage.json without the histograms.
// Cost: see coverage::coverage; memory about 250 bytes a facet.
[[nodiscard]] Outcome coverage_stage(const CoverageInputs& in, const std::filesystem::path& out,
                                     const CoverageStageOptions& options, base::RunContext& ctx);

// The recipe's stage `coverage`: reads surface.tif of stage `terrain`.
[[nodiscard]] std::unique_ptr<Stage> make_coverage_stage();

}  // namespace cairn::pipeline
