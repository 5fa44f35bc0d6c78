#include "ground/scan_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"

namespace cairn::ground {
namespace {

using geometry::GridGeometry;
using geometry::Pose2;
using geometry::Vec2;

void check(const survey::RangeScan& scan) {
  const auto refuse = [&](std::string message, const std::string& found) {
    throw base::Error(base::ErrorCode::invalid_input, std::move(message))
        .record("scan at " + std::to_string(scan.time_ns) + " ns")
        .found(found);
  };
  if (!std::isfinite(scan.angle_min) || !std::isfinite(scan.angle_increment) || scan.angle_increment == 0.0)
    refuse("a scan without usable angles",
           "from " + base::to_text(scan.angle_min) + " rad by " + base::to_text(scan.angle_increment));
  if (!(scan.range_min_m >= 0.0 && scan.range_max_m > scan.range_min_m) || !std::isfinite(scan.range_max_m))
    refuse("a scan without usable range limits",
           base::to_text(scan.range_min_m) + " to " + base::to_text(scan.range_max_m) + " m");
  if (scan.time_increment_ns < 0) refuse("a scan that runs back in time", std::to_string(scan.time_increment_ns));
}

// Part of the segment (in 0..1) inside the grid; empty where it misses it.
std::optional<std::pair<double, double>> clipped(const Vec2& from, const Vec2& to, const GridGeometry& g) {
  double begin = 0.0, end = 1.0;
  const Vec2 d = to - from, lo(g.west, g.south()), hi(g.east(), g.north);
  for (int axis = 0; axis < 2; ++axis) {
    if (d[axis] == 0.0) {
      if (from[axis] < lo[axis] || from[axis] > hi[axis]) return std::nullopt;
      continue;
    }
    double enter = (lo[axis] - from[axis]) / d[axis], leave = (hi[axis] - from[axis]) / d[axis];
    if (enter > leave) std::swap(enter, leave);
    begin = std::max(begin, enter);
    end = std::min(end, leave);
  }
  if (begin > end) return std::nullopt;
  return std::pair(begin, end);
}

}  // namespace

ScanMap::ScanMap(const GridGeometry& geometry, const ScanMapOptions& options)
    : options_(options),
      grid_(geometry, Occupancy::unknown),
      evidence_(geometry.cells(), 0),
      seen_in_(geometry.cells(), 0) {
  base::validate(base::bind_options(options_), "scan map");
}

std::optional<ScanMap::Ray> ScanMap::ray_of(const survey::RangeScan& scan, std::size_t index, const PoseAt& pose_at) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto range = static_cast<double>(scan.ranges[index]);
  if (std::isnan(range) || (range == kInfinity && !options_.infinite_clears)) {
    ++counts_.no_measurement;
    return std::nullopt;
  }
  if (range < std::max(scan.range_min_m, options_.min_range_m)) {
    ++counts_.too_near;
    return std::nullopt;
  }
  if (range != kInfinity && range > scan.range_max_m) {
    ++counts_.too_far;
    return std::nullopt;
  }
  const auto pose = pose_at(scan.time_ns + static_cast<std::int64_t>(index) * scan.time_increment_ns);
  if (!pose || !pose->position.allFinite() || !std::isfinite(pose->yaw)) {
    ++counts_.without_pose;
    return std::nullopt;
  }
  const Pose2 sensor{pose->to_world({options_.sensor_forward_m, options_.sensor_left_m}),
                     pose->yaw + base::deg_to_rad(options_.sensor_yaw_deg)};
  const double angle = sensor.yaw + scan.angle_min + static_cast<double>(index) * scan.angle_increment;
  const bool hit = range <= options_.obstacle_range_m;
  // Something stands at the end of a finite ray: the ground is free before it only.
  const double seen = range - 1.5 * grid_.geometry.cell;
  const double length = hit ? range : std::max(0.0, std::min({seen, options_.clear_range_m, scan.range_max_m}));
  ++(hit ? counts_.marked : counts_.cleared_only);
  return Ray{sensor.position, sensor.position + length * Vec2(std::cos(angle), std::sin(angle)), hit};
}

void ScanMap::weigh(std::size_t row, std::size_t column, std::int64_t change, CellRegion& changed) {
  const std::size_t i = row * grid_.geometry.columns + column;
  if (seen_in_[i] == scan_number_) return;
  seen_in_[i] = scan_number_;
  const auto value = std::clamp<std::int64_t>(evidence_[i] + change, -options_.limit, options_.limit);
  evidence_[i] = static_cast<std::int8_t>(value);
  const Occupancy now = value > 0 ? Occupancy::occupied : (value < 0 ? Occupancy::free : Occupancy::unknown);
  if (now == grid_.values[i]) return;
  grid_.values[i] = now;
  changed = joined(changed, {row, column, 1, 1});
}

// Every cell that the ray passes, from the sensor to just before its end (Amanatides & Woo 1987).
void ScanMap::clear_along(const Ray& ray, CellRegion& changed) {
  const GridGeometry& g = grid_.geometry;
  const Vec2 d = ray.to - ray.from;
  const double reach = std::min(1.0, options_.clear_range_m / std::max(d.norm(), 1e-12));
  const auto span = clipped(ray.from, ray.from + reach * d, g);
  if (!span) return;
  // Cells as column and row, growing to the east and to the south.
  const Vec2 step_m(d.x(), -d.y());
  const Vec2 first = ray.from + reach * span->first * d, last = ray.from + reach * span->second * d;
  const auto cell = [&](const Vec2& p, int axis) {
    const double position = axis == 0 ? (p.x() - g.west) / g.cell : (g.north - p.y()) / g.cell;
    const auto count = static_cast<double>(axis == 0 ? g.columns : g.rows);
    return static_cast<std::int64_t>(std::clamp(std::floor(position), 0.0, count - 1.0));
  };
  std::int64_t at[2] = {cell(first, 0), cell(first, 1)};
  const std::int64_t end[2] = {cell(last, 0), cell(last, 1)};
  double next[2], per_cell[2];
  std::int64_t step[2];
  for (int axis = 0; axis < 2; ++axis) {
    const double start = axis == 0 ? (ray.from.x() - g.west) / g.cell : (g.north - ray.from.y()) / g.cell;
    const double slope = step_m[axis] / g.cell;
    step[axis] = slope > 0.0 ? 1 : -1;
    const double border = static_cast<double>(at[axis]) + (slope > 0.0 ? 1.0 : 0.0);
    next[axis] = slope == 0.0 ? std::numeric_limits<double>::infinity() : (border - start) / slope;
    per_cell[axis] = slope == 0.0 ? std::numeric_limits<double>::infinity() : 1.0 / std::abs(slope);
  }
  for (std::int64_t left = std::abs(end[0] - at[0]) + std::abs(end[1] - at[1]); left >= 0; --left) {
    weigh(static_cast<std::size_t>(at[1]), static_cast<std::size_t>(at[0]), -options_.pass, changed);
    if (left == 0) break;
    // Never past the last cell on either axis, so that rounding cannot lead out of the grid.
    int axis = next[0] <= next[1] ? 0 : 1;
    if (at[axis] == end[axis]) axis = 1 - axis;
    at[axis] += step[axis];
    next[axis] += per_cell[axis];
  }
}

CellRegion ScanMap::add(const survey::RangeScan& scan, const PoseAt& pose_at) {
  check(scan);
  ++counts_.scans;
  counts_.rays += scan.ranges.size();
  if (++scan_number_ == 0) {  // wrapped round: old stamps would look new
    std::fill(seen_in_.begin(), seen_in_.end(), 0U);
    scan_number_ = 1;
  }
  std::vector<Ray> rays;
  rays.reserve(scan.ranges.size());
  for (std::size_t i = 0; i < scan.ranges.size(); ++i)
    if (auto ray = ray_of(scan, i, pose_at)) rays.push_back(*ray);
  CellRegion changed;
  for (const Ray& ray : rays) {
    if (!ray.hit) continue;
    if (const auto cell = grid_.geometry.cell_at(ray.to)) weigh(cell->first, cell->second, options_.hit, changed);
  }
  for (const Ray& ray : rays) clear_along(ray, changed);
  return changed;
}

CellRegion ScanMap::add(const survey::RangeScan& scan, const Pose2& pose) {
  return add(scan, [&pose](std::int64_t) { return std::optional(pose); });
}

}  // namespace cairn::ground
