// Scans along a vehicle's track to a layer of a costmap.
#pragma once

#include <filesystem>
#include <vector>

#include "base/reject.hpp"
#include "base/run_context.hpp"
#include "ground/occupancy.hpp"
#include "ground/scan_map.hpp"
#include "io/json.hpp"
#include "pipeline/costmap_stage.hpp"

namespace cairn::pipeline {

struct ScanLayer {
  ground::CellRegion region;   // of the map; the scans reach no farther
  ground::OccupancyGrid grid;  // of that region
  std::vector<base::Reject> rejects;
  io::Json summary;

  // Rows from `first` on of the map into `strip`; unknown outside the region.
  void rows(std::size_t first, ground::OccupancyGrid& strip) const;
};

// Reads lidar.csv and vehicle.csv. Scans whose first ray has no pose, or that a leaning vehicle took, are rejected
// (outside_log, log_gap, tilted). Throws failed_precondition where no scan has a pose: another time base.
[[nodiscard]] ScanLayer gather_scans(const std::filesystem::path& scans, const std::filesystem::path& vehicle,
                                     const geometry::GridGeometry& map, const CostmapStageOptions& options,
                                     base::RunContext& ctx);

}  // namespace cairn::pipeline
