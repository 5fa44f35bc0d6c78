// Stage `layers`: the results of a survey as georeferenced layers and an inventory.
#pragma once

#include <filesystem>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "pipeline/outcome.hpp"

namespace cairn::pipeline {

// An empty path = there is no such product; its layer is written without features.
struct LayersInputs {
  std::filesystem::path survey;     // survey folder
  std::filesystem::path targets;    // targets.json
  std::filesystem::path rocks;      // rocks.json
  std::filesystem::path obstacles;  // obstacles.json
  std::filesystem::path gaps;       // gaps.json
};

struct LayersOptions {
  bool footprints = true;              // outlines of the images on the ground
  double max_footprint_range_m = 500;  // sight lines longer than this are cut
  bool kml = true;                     // inventory.kml; needs the EGM96 grid where heights are ellipsoidal

  void visit(base::OptionVisitor& v) {
    v.flag("footprints", footprints, "write the outline of each image on the ground");
    v.real("max-footprint-range-m", max_footprint_range_m, 1.0, 1e5, "sight lines longer than this are cut, m");
    v.flag("kml", kml, "write inventory.kml");
  }
};

// Writes layers.gpkg (targets, rocks, obstacles, frames, footprints, gaps), inventory.csv,
// inventory.geojson and inventory.kml into `out`.
// The ground of the footprints is a horizontal plane at the median foot of the rocks, else of the
// obstacles, else of the targets; without any of these there are no footprints.
// Throws crs_mismatch where a product is in another frame than the survey.
// Cost: linear in records; the files are built in memory.
[[nodiscard]] Outcome layers_stage(const LayersInputs& in, const std::filesystem::path& out,
                                   const LayersOptions& options, base::RunContext& ctx);

}  // namespace cairn::pipeline
