// 2-D scans of a ground vehicle to an occupancy grid: marking, clearing by ray tracing, deskew.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "base/options.hpp"
#include "geometry/pose2.hpp"
#include "ground/occupancy.hpp"
#include "survey/range_scan.hpp"

namespace cairn::ground {

struct ScanMapOptions {
  double min_range_m = 0.2;        // nearer hits are the vehicle itself
  double obstacle_range_m = 10.0;  // hits farther away do not mark: an error of 1 deg in heading is 0.17 m there
  double clear_range_m = 12.0;     // rays free the ground up to here at most
  bool infinite_clears = true;     // a ray that met nothing (+infinity, REP-117) frees the ground too
  // Evidence of a cell, a whole number (log-odds in units of their own): + hit, - pass, within +-limit. Occupied from 1
  // up, free from -1 down, unknown at 0. With the defaults one hit marks, and a cell that is full of evidence is
  // cleared after 6 scans that see through it (0.6 s at 10 Hz).
  std::int64_t hit = 2;
  std::int64_t pass = 1;
  std::int64_t limit = 6;
  // The sensor on the vehicle.
  double sensor_forward_m = 0.0;
  double sensor_left_m = 0.0;
  double sensor_yaw_deg = 0.0;  // of its forward axis from the vehicle's, counter-clockwise

  void visit(base::OptionVisitor& v) {
    v.real("scan-min-range-m", min_range_m, 0.0, 100.0, "nearer hits of a scan are left out");
    v.real("scan-obstacle-range-m", obstacle_range_m, 0.1, 1000.0, "farther hits of a scan do not mark");
    v.real("scan-clear-range-m", clear_range_m, 0.1, 1000.0, "rays free the ground up to here");
    v.flag("scan-infinite-clears", infinite_clears, "rays that met nothing free the ground too");
    v.integer("scan-hit", hit, 1, 100, "evidence that a hit adds");
    v.integer("scan-pass", pass, 1, 100, "evidence that a ray seen through takes away");
    v.integer("scan-limit", limit, 1, 100, "most evidence for or against an obstacle");
    v.real("sensor-forward-m", sensor_forward_m, -100.0, 100.0, "scanner ahead of the vehicle's position");
    v.real("sensor-left-m", sensor_left_m, -100.0, 100.0, "scanner to the left of the vehicle's position");
    v.real("sensor-yaw-deg", sensor_yaw_deg, -180.0, 180.0, "scanner turned counter-clockwise on the vehicle");
  }
};

// The vehicle's pose at a time of the scan's time base; empty where it is not known.
using PoseAt = std::function<std::optional<geometry::Pose2>(std::int64_t time_ns)>;

struct ScanCounts {
  std::uint64_t scans = 0, rays = 0;
  std::uint64_t marked = 0;          // rays that marked a cell
  std::uint64_t cleared_only = 0;    // rays that met nothing, or only something beyond the obstacle range
  std::uint64_t too_near = 0;        // below range_min or min_range_m, and -infinity
  std::uint64_t too_far = 0;         // finite, but above range_max: no measurement
  std::uint64_t no_measurement = 0;  // NaN, and +infinity where it does not clear
  std::uint64_t without_pose = 0;
};

// Grid in the local frame that gathers scans. Cost of a scan: cells along its rays. Memory 6 bytes a cell.
class ScanMap {
 public:
  ScanMap(const geometry::GridGeometry& geometry, const ScanMapOptions& options);

  // Each ray starts where the sensor was at the ray's own time (deskew). Within one scan a cell that any ray hit is not
  // cleared by another, and counts once. Rays may start outside the grid. Returns the cells that may have changed.
  // Throws invalid_input for a scan without a usable geometry (increment 0 or not finite, range_min >= range_max).
  CellRegion add(const survey::RangeScan& scan, const PoseAt& pose_at);
  // A scan from a vehicle at rest.
  CellRegion add(const survey::RangeScan& scan, const geometry::Pose2& pose);

  [[nodiscard]] const OccupancyGrid& grid() const { return grid_; }
  [[nodiscard]] const ScanCounts& counts() const { return counts_; }

 private:
  struct Ray {
    geometry::Vec2 from, to;
    bool hit = false;
  };
  std::optional<Ray> ray_of(const survey::RangeScan& scan, std::size_t index, const PoseAt& pose_at);
  void weigh(std::size_t row, std::size_t column, std::int64_t change, CellRegion& changed);
  void clear_along(const Ray& ray, CellRegion& changed);

  ScanMapOptions options_;
  OccupancyGrid grid_;
  std::vector<std::int8_t> evidence_;
  std::vector<std::uint32_t> seen_in_;  // number of the scan that last weighed a cell
  std::uint32_t scan_number_ = 0;
  ScanCounts counts_;
};

}  // namespace cairn::ground
