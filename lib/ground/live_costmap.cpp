#include "ground/live_costmap.hpp"

#include <algorithm>
#include <utility>

namespace cairn::ground {
namespace {

// All of an obstacle that leaves a mark.
bool same_mark(const survey::Obstacle& a, const survey::Obstacle& b) {
  return a.kind == b.kind && a.position.head<2>() == b.position.head<2>() && a.width_m == b.width_m;
}

}  // namespace

LiveCostmap::LiveCostmap(OccupancyGrid prior, const LiveCostmapOptions& options)
    : options_(options),
      prior_(std::move(prior)),
      obstacles_(prior_.geometry, Occupancy::unknown),
      combined_(prior_),
      scans_(prior_.geometry, options.scans) {
  options_.cost.resolution_m = prior_.geometry.cell;
  cost_ = costmap(combined_, options_.cost);
}

void LiveCostmap::set_obstacles(std::span<const survey::Obstacle> obstacles) {
  if (std::equal(obstacles.begin(), obstacles.end(), current_.begin(), current_.end(), same_mark)) return;
  current_.assign(obstacles.begin(), obstacles.end());
  for (std::size_t r = marked_.row; r < marked_.end_row(); ++r)
    for (std::size_t c = marked_.column; c < marked_.end_column(); ++c) obstacles_.at(r, c) = Occupancy::unknown;
  const CellRegion now = mark_obstacles(obstacles, obstacles_).cells;
  changed_ = joined(changed_, joined(marked_, now));
  marked_ = now;
}

void LiveCostmap::add_scan(const survey::RangeScan& scan, const PoseAt& pose_at) {
  changed_ = joined(changed_, scans_.add(scan, pose_at));
}

CellRegion LiveCostmap::update() {
  if (changed_.empty()) return {};
  combine(prior_, &obstacles_, &scans_.grid(), options_.combine, changed_, combined_);
  return update_costmap(combined_, std::exchange(changed_, CellRegion{}), options_.cost, cost_);
}

}  // namespace cairn::ground
