// Obstacles and the known ground -> costmap (GeoTIFF) and ROS map.
#pragma once

#include <filesystem>

#include "base/run_context.hpp"
#include "ground/costmap.hpp"
#include "pipeline/outcome.hpp"

namespace cairn::pipeline {

struct CostmapInputs {
  std::filesystem::path obstacles;  // obstacles.json
  std::filesystem::path surface;    // surface.tif: its extent is mapped; cells without a height are unknown
};

// Writes costmap.tif (bands `cost` by paper B's equation (9) and `occupancy` 0/100, both 255 = unknown),
// map.pgm + map.yaml (trinary) and map.georeference.json. Cells keep the surface's corner, so that both
// rasters line up.
Outcome costmap_stage(const CostmapInputs& in, const std::filesystem::path& out, const ground::CostmapOptions& options,
                      base::RunContext& ctx);

}  // namespace cairn::pipeline
