// Stage `coverage`: surface + views -> what was seen, what was missed and why.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/run_context.hpp"
#include "coverage/audit.hpp"
#include "coverage/block_bootstrap.hpp"
#include "coverage/coverage.hpp"
#include "coverage/gaps.hpp"
#include "coverage/target_audit.hpp"
#include "pipeline/outcome.hpp"
#include "pipeline/stage.hpp"

namespace cairn::pipeline {

struct CoverageInputs {
  std::filesystem::path surface;        // GeoTIFF with a band `surface`, mesh, cloud, or targets.json (their cylinders)
  std::filesystem::path views;          // survey folder, or a camera table
  std::string format = "auto";          // auto: a folder is a survey, a file is a camera table; survey; pinhole-table
  std::filesystem::path targets = {};   // targets.json; "" = none
  std::filesystem::path contacts = {};  // contact.csv of those targets; "" = not known
  std::vector<std::string> points = {};     // queries: "EAST,NORTH[,UP]", see parse_points
  std::vector<std::string> viewsheds = {};  // the same, the places of eyes
};

struct CoverageStageOptions {
  coverage::CoverageOptions visibility;  // its flag `metrics` must be on
  coverage::GateOptions gates;
  coverage::GapOptions gaps;
  coverage::BootstrapOptions bootstrap;
  coverage::TargetOptions targets;
  double sample_edge_m = 1.0;        // facets with a longer edge are cut for the audit; 0 = never
  bool facets_csv = false;           // facets.csv: a row a facet
  double raster_cell_m = 0.25;       // cell of views.tif where the surface is a mesh
  double max_blur_px = 0.5;          // frames blurred more by the flight are counted
  double eye_height_m = 1.6;         // above the surface, of a viewshed's eye without a height
  bool page = false;                 // audit.html
  bool layers = false;               // coverage.gpkg
  std::string colour_mesh = "none";  // coverage.ply, coverage.glb in the colours of this metric

  void visit(base::OptionVisitor& v);
};

// Writes into `out`:
//   coverage.json          completeness with its interval, area by verdict, sides apart, gates, histograms,
//   percentiles,
//                          overlap, frames, with definitions
//   views.tif              float bands `views`, `gsd_mm`, `incidence_deg`, `parallax_deg`, `parallax_second_deg`,
//                          `azimuth_bins`, `sigma_mm`, `overlap`: the worst of a cell's facets; NaN where nothing was
//                          observed. For a mesh: of the facet seen from straight above. Not without a frame.
//   gaps.json              connected patches that fail (survey::CoverageGap). Not without a frame.
//   frames_coverage.csv    a row a frame: sampling distance, speed, exposure, blur
//   targets_coverage.csv, targets_coverage.json   a row a target, where targets are given
//   facets.csv, audit.html, coverage.gpkg (not without a frame), coverage.ply and coverage.glb   on request
//   points.json, viewshed.csv, viewshed.tif        where asked, see coverage_queries.hpp
// The summary is coverage.json without the histograms.
// Cost: see coverage::coverage; memory about 300 bytes a facet.
[[nodiscard]] Outcome coverage_stage(const CoverageInputs& in, const std::filesystem::path& out,
                                     const CoverageStageOptions& options, base::RunContext& ctx);

// The recipe's stage `coverage`: reads surface.tif of stage `terrain`, and targets.json of stage `locate` where it ran.
[[nodiscard]] std::unique_ptr<Stage> make_coverage_stage();

}  // namespace cairn::pipeline
