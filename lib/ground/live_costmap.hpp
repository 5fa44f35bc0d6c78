// A costmap that follows a drive: prior map, obstacles from the air and the vehicle's own scans, kept up to date.
#pragma once

#include <span>
#include <vector>

#include "ground/costmap.hpp"
#include "ground/occupancy.hpp"
#include "ground/scan_map.hpp"
#include "survey/obstacle.hpp"
#include "survey/range_scan.hpp"

namespace cairn::ground {

struct LiveCostmapOptions {
  CostmapOptions cost;  // resolution_m is that of the prior map
  CombineOptions combine;
  ScanMapOptions scans;
};

// Memory 10 bytes a cell. A tick with a scan of 10 m range at 0.05 m takes a few milliseconds.
class LiveCostmap {
 public:
  LiveCostmap(OccupancyGrid prior, const LiveCostmapOptions& options);

  // Replaces the layer of obstacles from the air; only what differs from the last one counts as changed.
  void set_obstacles(std::span<const survey::Obstacle> obstacles);
  void add_scan(const survey::RangeScan& scan, const PoseAt& pose_at);

  // Combines and inflates what has changed since the last call. Returns the cells that were written (empty = nothing).
  CellRegion update();

  // As of the last update().
  [[nodiscard]] const geometry::Grid<std::uint8_t>& cost() const { return cost_; }
  [[nodiscard]] const OccupancyGrid& occupancy() const { return combined_; }
  [[nodiscard]] const ScanMap& scans() const { return scans_; }

 private:
  LiveCostmapOptions options_;
  OccupancyGrid prior_, obstacles_, combined_;
  ScanMap scans_;
  geometry::Grid<std::uint8_t> cost_;
  CellRegion marked_;  // holds every cell of the obstacle layer that is not `unknown`
  std::vector<survey::Obstacle> current_;
  CellRegion changed_;  // since the last update
};

}  // namespace cairn::ground
