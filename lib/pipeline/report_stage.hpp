// Stage `report`: the products of a job -> one self-contained HTML page.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "pipeline/outcome.hpp"
#include "pipeline/stage.hpp"
#include "report/html_report.hpp"

namespace cairn::pipeline {

struct ReportStageOptions {
  report::ReportOptions page;
  std::int64_t photos_per_object = 3;  // crops with the best score, of different photographs
  std::int64_t photo_px = 224;         // side of a crop
  double colour_cell_m = 0.15;         // of the map's colours from the cloud
  bool colours = true;

  void visit(base::OptionVisitor& v) {
    page.visit(v);
    v.integer("photos-per-object", photos_per_object, 0, 20, "Photograph crops of each object");
    v.integer("photo-px", photo_px, 48, 1024, "Side of a crop, pixels");
    v.real("colour-cell-m", colour_cell_m, 0.01, 100.0, "Cell of the map's colours, m");
    v.flag("colours", colours, "Colour the map from the survey's cloud");
  }
};

struct ReportInputs {
  std::filesystem::path products;  // folder of the results
  std::filesystem::path survey;    // survey folder; "" = none: no photographs, frames and footprints
  // Stages of the recipe whose products count; empty = all that is there. A folder may hold products
  // of an earlier recipe that this one does not make.
  std::vector<std::string> stages;
  // Whether run.json of the products is read for seed, options and input hashes. A recipe's own
  // stage runs before that file is complete and must not.
  bool read_run_record = false;

  // Path of a stage's product; "" where it does not count or is not there.
  [[nodiscard]] std::filesystem::path product(std::string_view stage, const std::string& name) const;
};

// What the report shows, read from targets.json, rocks.json, rocks/<id>.{ply,json}, obstacles.json, coverage.json,
// gaps.json, surface.tif, views.tif, costmap.tif, route.json and .cairn/<stage>.json. Each may be absent; then its
// part of the report is, too. A file that is there and cannot be read is an error.
// Throws crs_mismatch where products and survey stand in different frames.
[[nodiscard]] report::ReportData gather_report(const ReportInputs& in, const ReportStageOptions& options,
                                               base::RunContext& ctx);

// Writes index.html into `folder`. Summary: objects, rocks, bytes, and what was missing.
Outcome report_stage(const ReportInputs& in, const std::filesystem::path& folder, const ReportStageOptions& options,
                     base::RunContext& ctx);

// The recipe's stage: -> report/index.html.
[[nodiscard]] std::unique_ptr<Stage> make_report_stage();

}  // namespace cairn::pipeline
